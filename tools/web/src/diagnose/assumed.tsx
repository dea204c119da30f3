import { useEffect, useState } from "react";
import { answered, api, type Schemas } from "../api/client";
import { Card } from "../ui/parts";
import type { Assumed } from "./ask";
import { first, plain } from "./words";

type Machine = Schemas["Machines"]["machines"][number];

function MachineShown({ machine }: { machine: Machine }) {
  return (
    <figure className="machine">
      <img src={machine.picture} alt={`Picture of the ${plain(machine.name)}`} />
      <figcaption className="hint">{machine.about}</figcaption>
    </figure>
  );
}

// Changing a choice answers again at once; the least effect waits for Enter or leaving the field.
export function ChangeAssumed({ assumed, onChange, busy }: {
  assumed: Assumed;
  onChange: (assumed: Assumed) => void;
  busy: boolean;
}) {
  const [machines, setMachines] = useState<Machine[]>([]);
  const [least, setLeast] = useState(assumed.least);
  useEffect(() => { answered(api.GET("/api/machines")).then((all) => setMachines(all.machines), () => setMachines([])); }, []);
  useEffect(() => setLeast(assumed.least), [assumed.least]);
  const shown = machines.find((one) => one.name === assumed.machine);
  const commit = () => { if (least.trim() !== assumed.least) onChange({ ...assumed, least: least.trim() }); };
  return (
    <Card title="Change what was assumed">
      <p className="hint">Leave a field at “as the file says” if the file is right. A change answers again with the same files.</p>
      <div className="row">
        <label>Machine
          <select value={assumed.machine} disabled={busy} onChange={(event) => onChange({ ...assumed, machine: event.target.value })}>
            <option value="">none named</option>
            {machines.map((one) => <option key={one.name} value={one.name}>{first(plain(one.name))}</option>)}
          </select>
        </label>
        <label>Unit of the readings
          <select value={assumed.unit} disabled={busy}
                  onChange={(event) => onChange({ ...assumed, unit: event.target.value as Assumed["unit"] })}>
            <option value="">as the file says</option>
            <option value="mm">mm</option><option value="um">µm</option>
            <option value="inch">inch</option><option value="thou">thou (0.001 inch)</option>
          </select>
        </label>
        <label>Axis
          <select value={assumed.axis} disabled={busy}
                  onChange={(event) => onChange({ ...assumed, axis: event.target.value as Assumed["axis"] })}>
            <option value="">as the file says</option>
            <option value="x">X</option><option value="y">Y</option><option value="z">Z</option>
          </select>
        </label>
        <label>Least effect of interest, µm
          <input type="number" inputMode="decimal" min="0" step="any" value={least} disabled={busy} placeholder="any"
                 onChange={(event) => setLeast(event.target.value)} onBlur={commit}
                 onKeyDown={(event) => { if (event.key === "Enter") commit(); }} />
        </label>
      </div>
      {shown ? <MachineShown machine={shown} /> : null}
    </Card>
  );
}
