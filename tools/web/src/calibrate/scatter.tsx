import { axes, type Axis, type Reading } from "./model";

interface Cluster { sense: 1 | -1; points: { n: number; um: number }[]; mean: number; sd: number }
interface Face { feature: string; axis: Axis; clusters: Cluster[] }

function clusterOf(sense: 1 | -1, points: Cluster["points"]): Cluster {
  const mean = points.reduce((sum, one) => sum + one.um, 0) / points.length;
  const square = points.reduce((sum, one) => sum + (one.um - mean) ** 2, 0);
  return { sense, points, mean, sd: points.length > 1 ? Math.sqrt(square / (points.length - 1)) : 0 };
}

// Readings of each face, split by the sense in which the axis came.
export function facesOf(readings: Reading[]): Face[] {
  const groups = new Map<string, Reading[]>();
  for (const one of readings) groups.set(one.feature, [...(groups.get(one.feature) ?? []), one]);
  return [...groups].map(([feature, group]) => {
    const axis = axes.find((one) => Math.abs(group[0]!.n[one]) > 0.5) ?? "x";
    const all = group.map((one, n) => ({ n: n + 1, um: one.value_mm * 1000, sense: one.dir[axis] }));
    const clusters = ([1, -1] as const)
      .map((sense) => ({ sense, points: all.filter((one) => Math.sign(one.sense) === sense) }))
      .filter((one) => one.points.length > 0)
      .map((one) => clusterOf(one.sense, one.points));
    return { feature, axis, clusters };
  });
}

const faceName = (feature: string) => `${feature.split(".").at(-1) ?? feature} face`;
const senseName = (sense: number, axis: Axis) => `moving ${sense > 0 ? "+" : "−"}${axis.toUpperCase()}`;

// Two to five round numbers, evenly apart.
function ticksIn(low: number, high: number): number[] {
  const rough = (high - low) / 5;
  const ten = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((times) => times * ten).find((one) => one >= rough) ?? rough;
  const first = Math.ceil(low / step);
  return Array.from({ length: Math.floor(high / step) - first + 1 }, (_, i) => (first + i) * step);
}

function Plot({ face }: { face: Face }) {
  const all = face.clusters.flatMap((one) => one.points);
  const low = Math.min(...all.map((one) => one.um));
  const high = Math.max(...all.map((one) => one.um));
  const room = Math.max(2, (high - low) * 0.15);
  const last = Math.max(...all.map((one) => one.n), 10);
  const x = (n: number) => 48 + (n / last) * 300;
  const y = (um: number) => 150 - ((um - low + room) / (high - low + 2 * room)) * 140;
  const ticks = ticksIn(low - room, high + room);
  return (
    <svg viewBox="0 0 360 185" className="cal-plot" aria-hidden="true">
      {ticks.map((um) => (
        <g key={um}>
          <line x1={48} x2={352} y1={y(um)} y2={y(um)} className="cal-grid" />
          <text x={44} y={y(um) + 4} textAnchor="end">{Number(um.toFixed(2))}</text>
        </g>
      ))}
      <text x={200} y={180} textAnchor="middle">touch 1 to {last} · reading in µm</text>
      {face.clusters.map((one) => (
        <g key={one.sense} className={one.sense > 0 ? "cal-plus" : "cal-minus"}>
          <line x1={48} x2={352} y1={y(one.mean)} y2={y(one.mean)} className="cal-mean" />
          {one.points.map((point) => (one.sense > 0
            ? <circle key={point.n} cx={x(point.n)} cy={y(point.um)} r={3.2} />
            : <rect key={point.n} x={x(point.n) - 3} y={y(point.um) - 3} width={6} height={6} />))}
        </g>
      ))}
    </svg>
  );
}

function FaceFigure({ face }: { face: Face }) {
  const [first, second] = face.clusters;
  const apart = first && second ? Math.abs(first.mean - second.mean) : null;
  return (
    <figure className="cal-figure">
      <figcaption>
        <strong>{faceName(face.feature)}</strong>
        {apart === null ? ": one sense so far" : `: the two clusters lie ${apart.toFixed(1)} µm apart`}
      </figcaption>
      <Plot face={face} />
      <table>
        <thead>
          <tr><th scope="col">Sense</th><th scope="col" className="number">Touches</th>
            <th scope="col" className="number">Mean ± scatter</th></tr>
        </thead>
        <tbody>
          {face.clusters.map((one) => (
            <tr key={one.sense}>
              <td><span className={one.sense > 0 ? "cal-key-plus" : "cal-key-minus"} aria-hidden="true" />
                {senseName(one.sense, face.axis)}</td>
              <td className="number">{one.points.length}</td>
              <td className="number">{one.mean.toFixed(1)} ± {one.sd.toFixed(1)} µm</td>
            </tr>
          ))}
        </tbody>
      </table>
    </figure>
  );
}

export function Scatter({ readings }: { readings: Reading[] }) {
  const faces = facesOf(readings);
  return (
    <>
      {faces.length === 0 ? <p className="hint">No readings yet. They appear here as the probe touches.</p> : (
        <>
          <p className="hint">
            The probe triggers on the way in and releases on the way out. Backlash sets the two apart. The gap
            also holds the switch's own hysteresis and delay, which the result takes off.
          </p>
          <div className="columns">{faces.map((face) => <FaceFigure key={face.feature} face={face} />)}</div>
        </>
      )}
    </>
  );
}
