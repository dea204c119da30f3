import { useState, type FormEvent } from "react";
import { Card } from "../ui/parts";

const units = ["mm", "um", "inch", "thou"] as const;

function Unit({ name, value, onChange }: { name: string; value: string; onChange: (unit: string) => void }) {
  return (
    <label>{name}
      <select value={value} onChange={(event) => onChange(event.target.value)}>
        {units.map((unit) => <option key={unit} value={unit}>{unit === "um" ? "µm" : unit}</option>)}
      </select>
    </label>
  );
}

interface Found { at: string; name: string }

// From "which column is which? Found: 1 'time', 2 'read'", or without headings "1 (10.0 ...)".
export function columnsFound(detail: string): Found[] {
  return [...detail.matchAll(/(\d+) (?:'([^']*)'|\((.*?) \.\.\.\))/g)].map((match) => ({ at: match[1]!, name: match[2] ?? `begins with ${match[3]}` }));
}

function Column({ name, found, value, onChange }: {
  name: string;
  found: Found[];
  value: string;
  onChange: (column: string) => void;
}) {
  return (
    <label>{name}
      <select value={value} onChange={(event) => onChange(event.target.value)}>
        {found.map((one) => <option key={one.at} value={one.at}>{one.at}: {one.name}</option>)}
      </select>
    </label>
  );
}

// For a table whose headings say nothing: what `--map` says on the command line.
// `file`: which, where several came; it is then answered by itself.
export function Columns({ file, found, onMap }: { file: string; found: Found[]; onMap: (map: string) => void }) {
  const [axis, setAxis] = useState("x");
  const [told, setTold] = useState("1");
  const [toldUnit, setToldUnit] = useState("mm");
  const [read, setRead] = useState("2");
  const [readUnit, setReadUnit] = useState("mm");
  const [kind, setKind] = useState("actual_mm");
  const submit = (event: FormEvent) => {
    event.preventDefault();
    onMap(`cmd_${axis}_mm=${told}[${toldUnit}],${kind}=${read}[${readUnit}]`);
  };
  return (
    <Card title={`Say which column is which${file ? `: ${file}` : ""}`}>
      {file ? <p className="hint">This file is then answered by itself. The answers to the others stay under “Answers of this visit”.</p> : null}
      <form onSubmit={submit}>
        <div className="row">
          <label>Axis
            <select value={axis} onChange={(event) => setAxis(event.target.value)}>
              <option value="x">X</option><option value="y">Y</option><option value="z">Z</option>
            </select>
          </label>
          <Column found={found} name="What was commanded" value={told} onChange={setTold} />
          <Unit name="Unit of the commanded" value={toldUnit} onChange={setToldUnit} />
          <Column found={found} name="What was measured" value={read} onChange={setRead} />
          <Unit name="Unit of the measured" value={readUnit} onChange={setReadUnit} />
          <label>Measured is
            <select value={kind} onChange={(event) => setKind(event.target.value)}>
              <option value="actual_mm">the place reached</option>
              <option value="value_mm">how far it is off</option>
            </select>
          </label>
          <button type="submit">Answer again</button>
        </div>
      </form>
    </Card>
  );
}
