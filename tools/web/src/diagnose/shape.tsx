import { Curve } from "./curve";
import type { Knots } from "./types";
import { Scroll } from "./scroll";
import { first, followWord } from "./words";

const axisLabel = (name: string) => `${first(followWord(name))}, ${name === "t" ? "s" : "mm"}`;

// The error as a table over one or two things: the values run fastest along the last.
export function Shape({ knots, prefix }: { knots: Knots; prefix: string }) {
  const [one, two] = knots.covariates;
  if (knots.covariates.length > 2 || !one) return null;
  if (!two) return <Lines prefix={prefix} knots={knots} along={one} names={["Error, µm"]} />;
  if (one.startsWith("dir_")) {
    const names = (knots.knots[0] ?? []).map((sense) => (sense > 0 ? "Coming in the + direction, µm" : "Coming in the − direction, µm"));
    return <Lines prefix={prefix} knots={knots} along={two} names={names} />;
  }
  return <HeightMap prefix={prefix} knots={knots} />;
}

function Lines({ knots, along, names, prefix }: { knots: Knots; along: string; names: string[]; prefix: string }) {
  const x = knots.knots[knots.knots.length - 1] ?? [];
  const series = names.map((name, i) => ({
    name, values: knots.values_um.slice(i * x.length, (i + 1) * x.length), dashed: i > 0 }));
  return <Curve title={`${prefix}error over ${followWord(along)}`} x={x} xLabel={axisLabel(along)} series={series} />;
}

function HeightMap({ knots, prefix }: { knots: Knots; prefix: string }) {
  const [xs, ys] = [knots.knots[0] ?? [], knots.knots[1] ?? []];
  const most = Math.max(1e-9, ...knots.values_um.map(Math.abs));
  const title = `${prefix}error in µm over ${followWord(knots.covariates[0]!)} (to the right) and ${followWord(knots.covariates[1]!)} (upwards)`;
  const shade = (um: number) =>
    `color-mix(in srgb, var(${um > 0 ? "--warn" : "--accent"}) ${((45 * Math.abs(um)) / most).toFixed(0)}%, var(--card))`;
  return (
    <details>
      <summary>Map of the error</summary>
      <p className="hint">{first(title)}. Brown or yellow: above. Blue: below.</p>
      <Scroll label={title}><table className="heights">
        <thead><tr><th scope="col">mm</th>{xs.map((x) => <th key={x} scope="col" className="number">{x.toFixed(0)}</th>)}</tr></thead>
        <tbody>{ys.map((y, j) => [y, j] as const).reverse().map(([y, j]) => (
          <tr key={y}><th scope="row" className="number">{y.toFixed(0)}</th>
            {xs.map((x, i) => {
              const um = knots.values_um[i * ys.length + j] ?? 0;
              return <td key={x} className="number" style={{ background: shade(um) }}>{um.toFixed(0)}</td>;
            })}
          </tr>))}
        </tbody>
      </table></Scroll>
    </details>
  );
}
