import { useEffect, useRef, useState } from "react";
import { StopButton } from "../ui/emergency";
import { Busy, Card, Notice, withSd } from "../ui/parts";
import { highestScrew, isLevel, isRaised, isWithinNoise, mostOffset, nowhere, offsetOf, offsetSd, plain, screwNames, type BedStatus, type BedTilt, type ScrewName, type Screws } from "./maths";
import { Failure } from "./status";
import type { Bed, Grid } from "./use_bed";

type Wish = { title: string; verb: string; offsets: Screws };

function movesOf(wish: Screws, status: BedStatus): { name: ScrewName; by: number }[] {
  return screwNames.map((name, i) => ({ name, by: offsetOf(wish, name) - (status.screws[i]?.applied_mm ?? 0) }));
}

function moveText(by: number): string {
  if (Math.abs(by) < 0.0005) return "stays where it is";
  return by > 0 ? `rises by ${by.toFixed(3)} mm` : `sinks by ${(-by).toFixed(3)} mm`;
}

export function ScrewsCard({ bed, status, found, grid }: { bed: Bed; status: BedStatus; found: BedTilt; grid: Grid }) {
  const [wish, setWish] = useState<Wish | null>(null);
  const isBusy = bed.doing !== null || status.held_by !== null;
  const said = useRef<HTMLDivElement>(null);
  const raised = isRaised(status);
  const isDone = movesOf(found.z_offsets, status).every((move) => Math.abs(move.by) < 0.0005);
  return (
    <Card title="The three screws">
      <p>How far each motor is to raise its screw. One stays at 0: the others come up to it.</p>
      <div className="bed-motors">
        {screwNames.map((name, i) => (
          <Motor key={name} name={name} found={found} status={status} raised={status.screws[i]?.applied_mm ?? 0} />
        ))}
      </div>
      <div className="row">
        <button type="button" disabled={isBusy || isDone}
                onClick={() => setWish({ title: "Move the screws?", verb: "Move them now", offsets: found.z_offsets })}>
          Apply…
        </button>
        <button type="button" className="quiet" disabled={isBusy || !raised}
                onClick={() => setWish({ title: "Take the screws back?", verb: "Take them back now", offsets: nowhere })}>
          Take back…
        </button>
        {raised ? (
          <button type="button" disabled={isBusy} onClick={() => void bed.calibrate(grid, found)}>Check it</button>
        ) : null}
      </div>
      {bed.doing === "apply" ? <Busy text="The screws are moving" /> : null}
      <div ref={said} tabIndex={-1} className="bed-said">
        <Failure failed={bed.failed} doing="apply" />
        <State bed={bed} found={found} raised={raised} />
      </div>
      {bed.before ? <BeforeAfter before={bed.before} after={found} /> : null}
      {wish ? (
        <Confirm wish={wish} status={status} isGiven={found.source === "given"} close={() => setWish(null)}
                 go={() => {
                   setWish(null);
                   void bed.apply(wish.offsets).then(() => said.current?.focus());
                 }} />
      ) : null}
    </Card>
  );
}

function Motor({ name, found, status, raised }: { name: ScrewName; found: BedTilt; status: BedStatus; raised: number }) {
  const offset = offsetOf(found.z_offsets, name);
  const at = status.screws.find((screw) => screw.name === name)?.at_mm;
  const isApplied = Math.abs(offset - raised) < 0.0005;
  const [value, sd] = withSd(Number(plain(offset)) === 0 ? 0 : offset, offsetSd(found, status.screws, name), "mm").split(" ± ");
  const state = !isRaised(status) ? (Math.abs(offset) < 0.0005 ? "nothing to do" : "not applied")
    : isApplied ? "applied" : `raised by ${plain(raised)} mm so far`;
  return (
    <section className={`bed-motor ${name}`} aria-label={`Screw ${name}`}>
      <h3>{name}</h3>
      <p className="bed-offset">{sd ? `${value} mm` : value}</p>
      <p>{sd ? `± ${sd}` : highestScrew(found, status.screws)?.name === name ? "the highest" : "± not known"}</p>
      <p className={`bed-state ${isRaised(status) && isApplied ? "done" : ""}`}>{state}</p>
      <p className="hint">{at ? `at x ${at[0]}, y ${at[1]} mm` : "place not known"}</p>
    </section>
  );
}

function State({ bed, found, raised }: { bed: Bed; found: BedTilt; raised: boolean }) {
  if (bed.moved) {
    const moved = screwNames.map((name) => `${name} ${moveText(offsetOf(bed.moved!, name)).replace("rises", "rose").replace("sinks", "sank").replace("stays where it is", "stayed")}`);
    return (
      <Notice kind="good">
        <p><strong>Done: {moved.join(", ")}.</strong></p>
        {bed.movedNotes.map((note) => <p key={note}>{note[0]!.toUpperCase() + note.slice(1)}.</p>)}
        {raised ? <p>Choose “Check it” to touch the bed again and see what is left.</p> : <p>The screws stand as they did when the bed was touched.</p>}
      </Notice>
    );
  }
  if (raised) {
    return <p>The screws were moved since the bed was touched. “Check it” touches it again. “Take back” undoes the move.</p>;
  }
  if (isLevel(found)) return <p>Another round would not help: no screw is to be moved.</p>;
  return null;
}

function progressOf(before: BedTilt, after: BedTilt): string {
  const [was, is] = [mostOffset(before), mostOffset(after)];
  const tilts = `The tilt went from ${plain(before.tilt_angles.tilt_degrees)}° to ${plain(after.tilt_angles.tilt_degrees)}°.`;
  if (isLevel(after) || isWithinNoise(after)) return `${tilts} The bed is level: another round would gain nothing.`;
  if (is < 0.5 * was) return `${tilts} Another round helps: choose “Apply” again.`;
  return `${tilts} The screws did not do what they were told. Look at which motor turns which screw, at the pitch of the screws, and whether the bed can tilt freely.`;
}

function BeforeAfter({ before, after }: { before: BedTilt; after: BedTilt }) {
  const rows: [string, (bed: BedTilt) => string][] = [
    ["Tilt in all, °", (bed) => plain(bed.tilt_angles.tilt_degrees, 4)],
    ["Most a screw is to rise, mm", (bed) => plain(mostOffset(bed))],
    ["Residual, µm", (bed) => (bed.measured_points > 3 ? plain(bed.residual_mm * 1000, 1) : "not known")],
  ];
  return (
    <>
      <h3>Before and after</h3>
      <p>{progressOf(before, after)}</p>
      <div className="scroll">
        <table>
          <thead><tr><th scope="col">What</th><th scope="col" className="number">before</th><th scope="col" className="number">after</th></tr></thead>
          <tbody>
            {rows.map(([name, of]) => (
              <tr key={name}><th scope="row">{name}</th><td className="number">{of(before)}</td><td className="number">{of(after)}</td></tr>
            ))}
          </tbody>
        </table>
      </div>
    </>
  );
}

function Confirm({ wish, status, isGiven, close, go }: {
  wish: Wish;
  status: BedStatus;
  isGiven: boolean;
  close: () => void;
  go: () => void;
}) {
  const dialog = useRef<HTMLDialogElement>(null);
  useEffect(() => dialog.current?.showModal(), []);
  return (
    <dialog ref={dialog} className="bed-confirm" aria-labelledby="bed-confirm-title" onClose={close}>
      <h3 id="bed-confirm-title">{wish.title}</h3>
      <p>The printer {status.machine} will move now, homing first if it was not homed:</p>
      <ul>
        {movesOf(wish.offsets, status).map(({ name, by }) => (
          <li key={name} className={name}><span className="bed-dot" aria-hidden="true" /><strong>{name}</strong> {moveText(by)}</li>
        ))}
      </ul>
      {isGiven ? (
        <Notice kind="warn">
          <p>These offsets come from heights that were written in. Where the screws stood then is not known here: they are counted from where they stood when the server started. If screws were moved here earlier, they move by another amount than this list says.</p>
        </Notice>
      ) : null}
      <p>Take tools and prints off the bed, and hands out of the machine.</p>
      <div className="row">
        <button type="button" onClick={go}>{wish.verb}</button>
        <button type="button" className="quiet" onClick={() => dialog.current?.close()}>Do not move</button>
        <StopButton onPressed={() => dialog.current?.close()} />
      </div>
    </dialog>
  );
}
