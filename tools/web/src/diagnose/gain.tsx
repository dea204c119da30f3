import { Card } from "../ui/parts";
import type { Diagnosis, LeftOut } from "./types";
import { Scroll } from "./scroll";
import { nice, percent, size } from "./words";

function Bar({ name, um, most, kind }: { name: string; um: number; most: number; kind: string }) {
  return (
    <div className="bar-row">
      <dt>{name}</dt>
      <dd><span className={`bar ${kind}`} style={{ width: `${Math.max(1, (100 * um) / most) * 0.6}%` }} aria-hidden="true" /> {size(um)}</dd>
    </div>
  );
}

const kinds: ["runs_left_out" | "positions_left_out" | "ends_left_out", string][] = [
  ["runs_left_out", "runs left out in turn"], ["positions_left_out", "positions left out in turn"],
  ["ends_left_out", "the ends left out in turn"],
];

// "They would have shown changing pitch of the X screw from 5.7 um, ...": how small a fault
// these rows would have told. Only the text has it.
const wouldShow = (one: Diagnosis) =>
  one.text.split("\n").filter((line) => /^(They would have shown|They could not show|The baseline predicts)/.test(line));

function Sensitivity({ one }: { one: Diagnosis }) {
  const lines = wouldShow(one);
  if (lines.length === 0) return null;
  return (
    <Card title="How small a fault would have shown">
      {lines.map((line) => <p key={line}>{nice(line.replace(/^They /, "These readings ").replace("The baseline predicts rows it has not seen", "Plain settings alone predict readings that were kept aside").replace("the baseline takes it up", "the plain settings take it up").replace("noise floor", "scatter of the readings").replace(/readings is ([\d.]+) \(/, "readings is $1 µm (").replace("from what the richest model leaves", "from what no pattern explains"))}</p>)}
    </Card>
  );
}

export function GainCard({ one }: { one: Diagnosis }) {
  const gain = one.gain;
  if (!one.findings?.length) return <Sensitivity one={one} />;
  if (!gain || gain.rmse_before_um === null || gain.rmse_after_um === null) return null;
  if (gain.rmse_before_um <= 0 || gain.rmse_before_um === gain.rmse_after_um) return null;
  const most = Math.max(gain.rmse_before_um, gain.rmse_after_um, gain.noise_floor_um ?? 0);
  const left = kinds.flatMap(([key, name]): [string, LeftOut][] => (gain[key] ? [[name, gain[key]]] : []));
  return (
    <Card title="What correcting it would gain">
      <dl className="bars">
        <Bar name="Error now" um={gain.rmse_before_um} most={most} kind="before" />
        <Bar name="Error after correction" um={gain.rmse_after_um} most={most} kind="after" />
        {gain.noise_floor_um !== null
          ? <Bar name="Scatter of the readings" um={gain.noise_floor_um} most={most} kind="floor" />
          : null}
      </dl>
      <p className="hint">
        All are root mean square errors{gain.held_out ? ", checked on readings that were kept aside" : ""}. The scatter comes from{" "}
        {gain.noise_floor_from === "replicates" ? "repeated readings" : "what no pattern explains"}; no correction gets below it.
        {gain.explained_fraction !== null ? ` Explained: ${percent(gain.explained_fraction)} of what can be.` : ""}
      </p>
      {left.length > 0 ? (
        <details>
          <summary>How well it predicts readings it has not seen</summary>
          <Scroll label="Readings kept aside"><table>
            <thead><tr><th>With</th><th className="number">Before</th><th className="number">After</th><th className="number">Rows</th></tr></thead>
            <tbody>{left.map(([name, part]) => (
              <tr key={name}><td>{name}</td><td className="number">{size(part.rmse_before_um)}</td>
                <td className="number">{size(part.rmse_after_um)}</td><td className="number">{part.rows}</td></tr>))}
            </tbody>
          </table></Scroll>
        </details>
      ) : null}
    </Card>
  );
}
