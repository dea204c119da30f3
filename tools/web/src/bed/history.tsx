import { Card } from "../ui/parts";
import { heightOf, isWithinNoise, mostOffset, offsetOf, plain, screwNames, when, type BedStatus, type BedTilt } from "./maths";

// `isRaised`: screws stand elsewhere than when the server first saw them. `isApplied`: they were
// moved after the last measurement.
function wordsOf(past: BedTilt[], isRaised: boolean, isApplied: boolean): string {
  const [last, before] = past;
  if (!last) return "";
  if (isApplied) return "The screws were moved after the last measurement: check now to see what that did.";
  if (last.is_level || isWithinNoise(last)) return "The bed is level: another round would gain nothing.";
  if (!before) return "One measurement so far. Apply, then check: the two are set side by side here.";
  const [now, then] = [mostOffset(last), mostOffset(before)];
  if (now < 0.5 * then) return `The last measurement is better: ${plain(now)} mm to raise instead of ${plain(then)} mm. Another round helps.`;
  if (now > 1.5 * then) return `The last measurement is worse: ${plain(now)} mm to raise instead of ${plain(then)} mm. Look for what moved before you go on.`;
  return `About as before: ${plain(now)} mm to raise, ${plain(then)} mm the time before. ${isRaised
    ? "Screws were moved here since the server began. If that was between these two, the bed does not follow: look at wiring and screws."
    : "No screw was moved in between, so nothing else was to be expected."}`;
}

export function History({ past, status }: { past: BedTilt[]; status: BedStatus }) {
  return (
    <Card title="Compared with earlier measurements">
      <p>{wordsOf(past, status.screws.some((screw) => Math.abs(screw.raised_mm) >= 0.0005), status.is_applied)}</p>
      <div className="bed-history">
        <Overlay past={past} status={status} />
        <div className="scroll" tabIndex={0} role="region" aria-label="Measurements, newest first">
          <table>
            <thead>
              <tr><th scope="col">When</th><th scope="col" className="number">points</th><th scope="col" className="number">tilt, °</th>
                {screwNames.map((name) => <th key={name} scope="col" className="number">{name}, mm</th>)}
                <th scope="col" className="number">residual, µm</th></tr>
            </thead>
            <tbody>
              {past.map((bed, i) => (
                <tr key={i}>
                  <th scope="row"><span className={`bed-line n${i}`} aria-hidden="true" /> {when(bed)}{i === 0 ? " (last)" : ""}{bed.source === "given" ? ", written in" : ""}</th>
                  <td className="number">{bed.measured_points}</td>
                  <td className="number">{plain(bed.tilt_angles.tilt_degrees, 4)}</td>
                  {screwNames.map((name) => <td key={name} className="number">{plain(offsetOf(bed.z_offsets, name))}</td>)}
                  <td className="number">{bed.measured_points > 3 ? plain(bed.residual_mm * 1000, 1) : "not known"}</td>
                </tr>
              ))}
            </tbody>
          </table>
        </div>
      </div>
    </Card>
  );
}

// Heights of the planes at the three screws, less the highest: level is a flat line.
function Overlay({ past, status }: { past: BedTilt[]; status: BedStatus }) {
  const depths = past.map((bed) => {
    const heights = status.screws.map((screw) => heightOf(bed.plane_equation, screw.at_mm[0]!, screw.at_mm[1]!));
    return heights.map((height) => height - Math.max(...heights));
  });
  const deepest = Math.max(0.01, ...depths.flat().map((depth) => -depth));
  const [left, right, top, bottom] = [60, 270, 20, 130];
  const x = (i: number) => left + ((right - left) * i) / Math.max(1, status.screws.length - 1);
  const y = (depth: number) => top + ((bottom - top) * -depth) / deepest;
  return (
    <svg className="bed-overlay" viewBox="0 0 300 165" role="img"
         aria-label="How far the plane lies below the highest screw at z1, z2 and z3, each measurement a line; the table has the numbers">
      <line x1={left} x2={right} y1={top} y2={top} className="bed-axis" />
      <text x={left - 8} y={top + 4} textAnchor="end">level</text>
      <text x={left - 8} y={bottom + 4} textAnchor="end">{`−${deepest.toFixed(2)}`}</text>
      <text x={left - 8} y={bottom - 10} textAnchor="end">mm</text>
      {status.screws.map((screw, i) => (
        <text key={screw.name} x={x(i)} y={154} textAnchor="middle">{screw.name}</text>
      ))}
      {depths.map((line, i) => (
        <polyline key={i} className={`bed-trace n${i}`} points={line.map((depth, k) => `${x(k)},${y(depth)}`).join(" ")} />
      )).reverse()}
    </svg>
  );
}
