import { useEffect, useState } from "react";
import { answered, api, type Schemas } from "../api/client";
import { Busy, Card, ProblemNotice } from "../ui/parts";
import type { Assumed, Refused } from "./ask";
import { stepsIn } from "./correction";
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

// A field that waits for Enter or for being left.
function Typed({ name, value, placeholder, onCommit }: {
  name: string;
  value: string;
  placeholder: string;
  onCommit: (value: string) => void;
}) {
  const [text, setText] = useState(value);
  useEffect(() => setText(value), [value]);
  const commit = () => { if (text.trim() !== value) onCommit(text.trim()); };
  return (
    <label>{name}
      <input inputMode="decimal" value={text} placeholder={placeholder} onChange={(event) => setText(event.target.value)} onBlur={commit}
             onKeyDown={(event) => { if (event.key === "Enter") commit(); }} />
    </label>
  );
}

function Choice<T extends string>({ name, value, options, onChange }: {
  name: string;
  value: T;
  options: [T, string][];
  onChange: (value: T) => void;
}) {
  return (
    <label>{name}
      <select value={value} onChange={(event) => onChange(event.target.value as T)}>
        {options.map(([key, words]) => <option key={key} value={key}>{words}</option>)}
      </select>
    </label>
  );
}

const units: [Assumed["unit"], string][] = [["", "as the file says"], ["mm", "mm"], ["um", "µm"], ["inch", "inch"], ["thou", "thou (0.001 inch)"]];
const axes: [Assumed["axis"], string][] = [["", "as the file says"], ["x", "X"], ["y", "Y"], ["z", "Z"]];

// Changing a choice answers again at once. `machineFile`: the file that the machine was read from.
export function ChangeAssumed({ assumed, refused, machineFile, onChange }: {
  assumed: Assumed;
  refused: Refused | null;
  machineFile: string | null;
  onChange: (assumed: Assumed) => void;
}) {
  const [machines, setMachines] = useState<Machine[]>([]);
  useEffect(() => { answered(api.GET("/api/machines")).then((all) => setMachines(all.machines), () => setMachines([])); }, []);
  const shown = machines.find((one) => one.name === assumed.machine);
  const known = machines.map((one): [string, string] => [one.name, first(plain(one.name))]);
  return (
    <div id="assumed">
    <Card title="Change what was assumed">
      <p className="hint">Leave a field at “as the file says” if the file is right. A change answers again with the same files.</p>
      <div className="row">
        <Choice name="Machine" value={assumed.machine} options={[["", machineFile ? `as ${machineFile} says` : "none named"], ...known]}
                onChange={(machine) => onChange({ ...assumed, machine })} />
        <Choice name="Unit of the readings" value={assumed.unit} options={units} onChange={(unit) => onChange({ ...assumed, unit })} />
        <Choice name="Axis" value={assumed.axis} options={axes} onChange={(axis) => onChange({ ...assumed, axis })} />
        <Typed name="Steps/mm set now" value={assumed.steps} placeholder="as the file says" onCommit={(steps) => onChange({ ...assumed, steps })} />
        <Typed name="Least effect of interest, µm" value={assumed.least} placeholder="any" onCommit={(least) => onChange({ ...assumed, least })} />
      </div>
      {assumed.steps && !(stepsIn(assumed.steps) > 0) ? <p role="status">“{assumed.steps}” are no steps/mm: write a number above 0.</p> : null}
      <p className="hint">Steps/mm set now: the settings to paste are worked out from it, and a log that counts motor steps is read by it.</p>
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
