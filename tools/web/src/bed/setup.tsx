import { useState } from "react";
import { Busy, Card, Notice } from "../ui/parts";
import { isRaised, readPoints, type BedStatus } from "./maths";
import { Failure } from "./status";
import type { Bed, Grid, Live } from "./use_bed";

const sizes = [2, 3, 4, 5];

export function Setup({ bed, status, grid, setGrid }: {
  bed: Bed;
  status: BedStatus;
  grid: Grid;
  setGrid: (grid: Grid) => void;
}) {
  const isBusy = bed.doing !== null || status.held_by !== null;
  const atScrews = () => bed.probe({
    probe_points: status.screws.map((screw) => screw.at_mm),
    use_printer: true,
    reference_height: grid.reference,
  });
  return (
    <Card title="Measure the bed">
      <p>The nozzle (or the probe beside it) touches the bed at a grid of points. The screws stay as they are: they move only when you choose “Apply” below and say yes.</p>
      {/* Not `disabled`, which would take the focus from the button that was pressed. */}
      <div className="row">
        <Size name="Rows (along y)" value={grid.rows} set={(rows) => setGrid({ ...grid, rows })} />
        <Size name="Columns (along x)" value={grid.columns} set={(columns) => setGrid({ ...grid, columns })} />
        <button type="button" aria-disabled={isBusy} onClick={() => { if (!isBusy) void bed.calibrate(grid); }}>
          Measure ({grid.rows * grid.columns} touches)
        </button>
        <button type="button" className="quiet" aria-disabled={isBusy} onClick={() => { if (!isBusy) void atScrews(); }}>
          Touch only at the three screws
        </button>
      </div>
      <p className="hint">Nine touches are good for most beds. Four at the corners tell tilt and twist, but no bowl. Three at the screws tell the tilt alone.</p>
      <Failure failed={bed.failed} doing="measure" />
      <Progress live={bed.live} doing={bed.doing} />
      <Heights bed={bed} grid={grid} isBusy={isBusy} status={status} />
      <Reference grid={grid} setGrid={setGrid} />
    </Card>
  );
}

function Size({ name, value, set }: { name: string; value: number; set: (value: number) => void }) {
  return (
    <label>{name}
      <select value={value} onChange={(event) => set(Number(event.target.value))}>
        {sizes.map((size) => <option key={size} value={size}>{size}</option>)}
      </select>
    </label>
  );
}

function Reference({ grid, setGrid }: { grid: Grid; setGrid: (grid: Grid) => void }) {
  return (
    <details>
      <summary>Reference height: {grid.reference} mm (leave it as it is)</summary>
      <label>Reference height, mm
        <input type="number" min={-1000} max={1000} step="any" value={grid.reference}
               onChange={(event) => setGrid({ ...grid, reference: Number(event.target.value) })} />
      </label>
      <p className="hint">The height the plane is compared with. It is the same for all three screws, so it cancels: whatever you write, the screws are raised by the same. Leave it unless other software of yours wants its own value in the record.</p>
    </details>
  );
}

export function Progress({ live, doing }: { live: Live | null; doing: Bed["doing"] }) {
  const done = live?.touches.length ?? 0;
  const last = live?.touches.at(-1);
  if (live?.fault) {
    return (
      <Notice kind="bad">
        <p><strong>The machine stopped after {done} of {live.points} touches.</strong> It said: {live.fault}</p>
      </Notice>
    );
  }
  return (
    <div aria-live="polite">
      {live ? (
        <div className="bed-progress">
          <progress value={done} max={live.points} aria-label="Touches done" />
          <span>{done} of {live.points} touches{last ? `; the last at x ${last.x}, y ${last.y}: ${last.z.toFixed(3)} mm` : ""}</span>
        </div>
      ) : doing === "measure" ? <Busy text="Asking the printer to touch the bed" /> : null}
    </div>
  );
}

function exampleOf(status: BedStatus): string {
  return status.screws.map((screw) => [...screw.at_mm, "0.00"].join(", ")).join("\n");
}

function Heights({ bed, grid, isBusy, status }: { bed: Bed; grid: Grid; isBusy: boolean; status: BedStatus }) {
  const [text, setText] = useState("");
  const [asked, setAsked] = useState(false);
  const { points, fault } = readPoints(text, 3);
  const send = () => {
    setAsked(true);
    if (fault) return;
    void bed.probe({ probe_points: points, use_printer: false, reference_height: grid.reference });
  };
  return (
    <details>
      <summary>Write in heights you measured yourself</summary>
      <p>One point a line: x, y and z in mm. x and y as the printer counts them; z is higher where the bed is higher.</p>
      <label className="bed-wide">Heights: x, y, z
        <textarea rows={5} value={text} placeholder={exampleOf(status)} aria-invalid={asked && fault !== null}
                  onChange={(event) => setText(event.target.value)} />
      </label>
      {asked && fault ? <Notice kind="bad"><p>{fault}</p></Notice> : null}
      {isRaised(status) ? (
        <Notice kind="warn">
          <p>The screws were moved here since the last measurement. Offsets of heights you write in are counted from where the screws stood when the server first saw them. To be sure, choose “Take back” first, then measure.</p>
        </Notice>
      ) : null}
      <p><button type="button" className="quiet" disabled={isBusy} onClick={send}>Use these heights</button></p>
    </details>
  );
}
