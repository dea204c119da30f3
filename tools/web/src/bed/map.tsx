import { offsetOf, residualColour, screwNames, signed } from "./maths";
import type { Shown } from "./scene";

// The bed seen from above: where a browser cannot draw in three dimensions.
export function BedMap({ shown }: { shown: Shown }) {
  const [width = 1, depth = 1] = shown.status.travel_mm;
  const up = (y: number) => depth - y;
  return (
    <svg className="bed-map" viewBox={`-20 -20 ${width + 40} ${depth + 40}`} role="img"
         aria-label="The bed from above; the table of touches has the same numbers">
      <rect x={0} y={0} width={width} height={depth} className="bed-map-travel" />
      {shown.touches.map((touch, i) => {
        const residual = shown.residuals?.[i] ?? null;
        return (
          <g key={i}>
            <circle cx={touch.x} cy={up(touch.y)} r={6} fill={residualColour(residual, shown.mostResidual)} />
            <text x={touch.x} y={up(touch.y) + 17} textAnchor="middle">{signed(touch.z)}</text>
          </g>
        );
      })}
      {shown.status.screws.map((screw, i) => {
        const [x = 0, y = 0] = screw.at_mm;
        const offset = shown.offsets ? offsetOf(shown.offsets, screwNames[i]!) : null;
        const raise = offset === null ? "" : offset < 0.0005 ? " stays" : ` ${signed(offset)} mm`;
        return (
          <g key={screw.name} className={screwNames[i]}>
            <circle cx={x} cy={up(y)} r={11} fill="none" stroke="var(--screw)" strokeWidth={3} />
            <text x={x} y={up(y) - 15} textAnchor="middle" className="bed-map-screw">{screw.name}{raise}</text>
          </g>
        );
      })}
    </svg>
  );
}
