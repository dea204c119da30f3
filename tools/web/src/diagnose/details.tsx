import { Card, withSd } from "../ui/parts";
import type { Diagnosis, Quantity } from "./types";
import { Scroll } from "./scroll";
import { baselineWord, nice } from "./words";

function Rows({ quantities }: { quantities: Quantity[] }) {
  return (
    <Scroll label="Plain settings"><table>
      <thead><tr><th>Quantity</th><th className="number">Off by (real minus set)</th></tr></thead>
      <tbody>{quantities.map((one) => (
        <tr key={one.name}>
          <td>{baselineWord(one.name)}</td>
          <td className="number">{one.determined ? withSd(one.value, one.sd, one.unit, one.unit === "ppm" ? 0 : 3) : "not known"}</td>
        </tr>))}
      </tbody>
    </table></Scroll>
  );
}

// A figure may be told by itself where it cannot be told from all others at once.
function NoneKnown({ one }: { one: Diagnosis }) {
  const told = (one.facts ?? []).filter((fact) => ["reversal", "scale", "plane", "squareness"].includes(fact.fact));
  if (told.length === 0) return <p>These readings determine none of them.</p>;
  return (
    <>
      <p>Fitted all at once, these readings settle none of them: one could stand in for another. Each looked at by itself, they say:</p>
      <ul>{told.map((fact) => <li key={fact.says}>{nice(fact.says)}.</li>)}</ul>
    </>
  );
}

export function Baseline({ one }: { one: Diagnosis }) {
  const all = one.baseline ?? [];
  if (all.length === 0) return null;
  const known = all.filter((part) => part.determined);
  const blind = all.filter((part) => !part.determined);
  return (
    <Card title="Plain settings, as measured">
      <p className="hint">These are always fitted first: scale, backlash, where things lie. ± is one standard deviation.</p>
      {known.some((part) => part.sd === null) ? <p className="hint">Without “±”: how sure the number is, is not known.</p> : null}
      {known.length > 0 ? <Rows quantities={known} /> : <NoneKnown one={one} />}
      {blind.length > 0 ? <details><summary>Not known from these readings ({blind.length})</summary><Rows quantities={blind} /></details> : null}
    </Card>
  );
}
