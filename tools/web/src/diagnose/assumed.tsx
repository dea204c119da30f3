import { useEffect, useState } from "react";
import { answered, api, type Schemas } from "../api/client";
import { Busy, Card, ProblemNotice } from "../ui/parts";
import type { Assumed, Refused } from "./ask";
import { first, plain } from "./words";

type Machine = Schemas["Machines"]["machines"][number];

function MachineShown({ machine }: { machine: Machine }) {
  const [state, setState] = useState<"coming" | "there" | "failed">("coming");
  return (
    <figure className="machine">
      {state === "coming" ? <Busy text="Drawing the machine" /> : null}
      {state === "failed" ? <p className="hint">No picture could be made.</p> : (
        <img src={machine.picture} alt={`Picture of the ${plain(machine.name)}`} className={state}
             onLoad={() => setState("there")} onError={() => setState("failed")} />
      )}
      <figcaption className="hint">{machine.about.replace(/ *Sources of the sizes:.*?file\.?/, "")}</figcaption>
    </figure>
  );
}

// Changing a choice answers again at once; the least effect waits for Enter or leaving the field.
export function ChangeAssumed({ assumed, refused, onChange }: {
  assumed: Assumed;
  refused: Refused | null;
  onChange: (assumed: Assumed) => void;
}) {
  const [machines, setMachines] = useState<Machine[]>([]);
  const [least, setLeast] = useState(assumed.least);
  useEffect(() => { answered(api.GET("/api/machines")).then((all) => setMachines(all.machines), () => setMachines([])); }, []);
  useEffect(() => setLeast(assumed.least), [assumed.least]);
  const shown = machines.find((one) => one.name === assumed.machine);
  const commit = () => { if (least.trim() !== assumed.least) onChange({ ...assumed, least: least.trim() }); };
  return (
    <div id="assumed">
    <Card title="Change what was assumed">
      <p className="hint">Leave a field at “as the file says” if the file is right. A change answers again with the same files.</p>
      <div className="row">
        <label>Machine
          <select value={assumed.machine} onChange={(event) => onChange({ ...assumed, machine: event.target.value })}>
            <option value="">none named</option>
            {machines.map((one) => <option key={one.name} value={one.name}>{first(plain(one.name))}</option>)}
          </select>
        </label>
        <label>Unit of the readings
          <select value={assumed.unit}
                  onChange={(event) => onChange({ ...assumed, unit: event.target.value as Assumed["unit"] })}>
            <option value="">as the file says</option>
            <option value="mm">mm</option><option value="um">µm</option>
            <option value="inch">inch</option><option value="thou">thou (0.001 inch)</option>
          </select>
        </label>
        <label>Axis
          <select value={assumed.axis}
                  onChange={(event) => onChange({ ...assumed, axis: event.target.value as Assumed["axis"] })}>
            <option value="">as the file says</option>
            <option value="x">X</option><option value="y">Y</option><option value="z">Z</option>
          </select>
        </label>
        <label>Least effect of interest, µm
          <input type="number" inputMode="decimal" min="0" step="any" value={least} placeholder="any"
                 onChange={(event) => setLeast(event.target.value)} onBlur={commit}
                 onKeyDown={(event) => { if (event.key === "Enter") commit(); }} />
        </label>
      </div>
      {refused ? (
        <div>
          <p><strong>That does not go with this file{refused.assumed.machine && refused.assumed.machine !== assumed.machine
            ? ` (machine: ${plain(refused.assumed.machine)})` : ""}.</strong> The answer above is still the one before.</p>
          {refused.problems.map((problem, i) => <ProblemNotice key={i} problem={problem} />)}
        </div>
      ) : null}
      {assumed.columns ? <p>Columns as you said: <code>{assumed.columns}</code>{" "}
        <button type="button" className="quiet" onClick={() => onChange({ ...assumed, columns: "" })}>Take back</button></p> : null}
      {shown ? <MachineShown key={shown.name} machine={shown} /> : null}
    </Card>
    </div>
  );
}
