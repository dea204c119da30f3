import { Card, Figure, Notice } from "../ui/parts";
import { flatnessOf } from "./flatness";
import { isLevel, isMoved, isWithinNoise, plain, signed, tiltOf, tiltSd, touchesOf, when, type BedTilt } from "./maths";

function answerOf(bed: BedTilt): { kind: "good" | "warn" | "info"; text: string } {
  const total = plain(bed.tilt_angles.tilt_degrees);
  if (isMoved(bed.applied) && bed.plane_now) {
    const now = plain(tiltOf(bed.plane_now));
    return { kind: "info", text: `The screws have moved. The bed stood ${total}° off level; if they did as told, ${now}° are left. Check it to be sure.` };
  }
  if (isLevel(bed)) return { kind: "good", text: "The bed is level. Nothing to do." };
  if (isWithinNoise(bed)) {
    return { kind: "good", text: "The bed is level, as far as these touches can tell." };
  }
  return { kind: "warn", text: `The bed is tilted by ${total}°. Raising the screws as shown below levels it.` };
}

// The verdict, at the top of the page.
export function Answer({ bed, isMeasuring }: { bed: BedTilt; isMeasuring: boolean }) {
  if (isMeasuring) {
    return (
      <Notice kind="info">
        <p className="bed-answer"><strong>The bed is being touched now.</strong></p>
        <p>The new result shows here. Until then the numbers below are of the measurement before.</p>
      </Notice>
    );
  }
  const answer = answerOf(bed);
  return (
    <Notice kind={answer.kind}>
      <p className="bed-answer"><strong>{answer.text}</strong></p>
      {isMoved(bed.applied) ? null : (bed.notes ?? []).map((note) => <p key={note}>{sentence(note)}</p>)}
    </Notice>
  );
}

export function Results({ bed }: { bed: BedTilt }) {
  return (
    <Card title="What was measured" aside={<a href="/api/calibration/report" target="_blank" rel="noreferrer">Printable report (new tab)</a>}>
      <p>
        {bed.measured_points} {bed.source === "given" ? "heights written in" : "touches by the printer"}, {when(bed)}.
        {isMoved(bed.applied) ? " Before the screws moved." : ""}
      </p>
      <Figures bed={bed} />
      <Residual bed={bed} />
      <Touches bed={bed} />
    </Card>
  );
}

function sentence(note: string): string {
  const text = note.charAt(0).toUpperCase() + note.slice(1);
  return /[.!?]$/.test(text) ? text : `${text}.`;
}

function Figures({ bed }: { bed: BedTilt }) {
  const sure = bed.uncertainty;
  const { a, b, c } = bed.plane_equation;
  const sides = bed.tilt_angles;
  return (
    <>
      <h3>Tilt</h3>
      <dl className="figures bed-figures">
        <Figure name="Along x (+: right high)" value={sides.tilt_x_degrees} sd={sure?.tilt_x_degrees} unit="°" digits={4} />
        <Figure name="Along y (+: back high)" value={sides.tilt_y_degrees} sd={sure?.tilt_y_degrees} unit="°" digits={4} />
        <Figure name="Both together" value={sides.tilt_degrees} sd={tiltSd(bed)} unit="°" digits={4} />
      </dl>
      {sure ? null : <p className="hint">How sure these are is not known: three points leave nothing over to tell it by.</p>}
      <details>
        <summary>Equation of the plane</summary>
        <p className="bed-equation">z = {plain(a, 6)} · x {b < 0 ? "−" : "+"} {Math.abs(b).toFixed(6)} · y {c < 0 ? "−" : "+"} {Math.abs(c).toFixed(4)} mm</p>
        <dl className="figures bed-figures">
          <Figure name="a, slope along x" value={a * 1000} sd={sure && sure.a * 1000} unit="mm per m" />
          <Figure name="b, slope along y" value={b * 1000} sd={sure && sure.b * 1000} unit="mm per m" />
          <Figure name="c, height at x = y = 0" value={c} sd={sure?.c} unit="mm" />
        </dl>
        <p className="hint">± is one standard deviation.</p>
      </details>
    </>
  );
}

function Residual({ bed }: { bed: BedTilt }) {
  const { kind, title, text, todo } = flatnessOf(bed);
  return (
    <>
      <h3>{title}</h3>
      <div className={`notice ${kind}`}>
        <p>{text}</p>
        {todo ? <p>{todo}</p> : null}
        {bed.measured_points > 3 ? <p className="hint">The residual is how far the touches lie from the plane, root mean square.</p> : null}
      </div>
    </>
  );
}

function Touches({ bed }: { bed: BedTilt }) {
  const points = touchesOf(bed);
  return (
    <details>
      <summary>Table of the {points.length} touches</summary>
      <div className="scroll" tabIndex={0} role="region" aria-label="Touches">
        <table>
          <thead>
            <tr><th scope="col">No.</th><th scope="col" className="number">x, mm</th><th scope="col" className="number">y, mm</th>
              <th scope="col" className="number">z, mm</th><th scope="col" className="number">above the plane, µm</th></tr>
          </thead>
          <tbody>
            {points.map((point, i) => {
              const residual = bed.residuals_mm?.[i];
              return (
                <tr key={i}>
                  <td>{i + 1}</td><td className="number">{plain(point.x, 1)}</td><td className="number">{plain(point.y, 1)}</td>
                  <td className="number">{signed(point.z)}</td>
                  <td className="number">{residual === undefined || points.length < 4 ? "not known" : signed(residual * 1000, 1)}</td>
                </tr>
              );
            })}
          </tbody>
        </table>
      </div>
    </details>
  );
}
