import { useEffect, useId, useRef, useState } from "react";
import uPlot from "uplot";
import { first } from "./words";
import { Scroll } from "./scroll";
import "uplot/dist/uPlot.min.css";

export interface Series { name: string; values: (number | null)[]; dashed?: boolean }

// A canvas knows no CSS variables: the colour that one stands for now, light or dark.
function colour(of: HTMLElement, name: string): string {
  const probe = document.createElement("span");
  probe.style.color = `var(${name})`;
  of.append(probe);
  const found = getComputedStyle(probe).color;
  probe.remove();
  return found;
}

function options(host: HTMLElement, xLabel: string, series: Series[]): uPlot.Options {
  const soft = colour(host, "--soft");
  const grid = { stroke: colour(host, "--line"), width: 1 };
  const strokes = [colour(host, "--accent"), colour(host, "--warn")];
  return {
    width: host.clientWidth,
    height: 240,
    scales: { x: { time: false } },
    axes: [{ stroke: soft, grid, label: xLabel }, { stroke: soft, grid, size: 60, label: "µm" }],
    series: [{ label: xLabel }, ...series.map((one, i) => ({
      label: one.name, stroke: strokes[i % strokes.length]!, width: 2, dash: one.dashed ? [6, 5] : undefined, points: { show: true },
    }))],
  };
}

export function Curve({ title, x, xLabel, series }: { title: string; x: number[]; xLabel: string; series: Series[] }) {
  const host = useRef<HTMLDivElement>(null);
  const [dark, setDark] = useState(false);
  const id = useId();
  const drawn = JSON.stringify([x, xLabel, series]);
  const current = useRef({ x, xLabel, series });
  current.current = { x, xLabel, series };
  useEffect(() => {
    const media = matchMedia("(prefers-color-scheme: dark)");
    const follow = () => setDark(media.matches);
    media.addEventListener("change", follow);
    return () => media.removeEventListener("change", follow);
  }, []);
  useEffect(() => {
    const box = host.current;
    const now = current.current;
    if (!box || now.x.length === 0) return;
    const plot = new uPlot(options(box, now.xLabel, now.series), [now.x, ...now.series.map((one) => one.values)], box);
    const resized = new ResizeObserver(() => plot.setSize({ width: box.clientWidth, height: 240 }));
    resized.observe(box);
    return () => { resized.disconnect(); plot.destroy(); };
  }, [drawn, dark]);
  return (
    <figure className="curve">
      <figcaption id={id}>{first(title)}</figcaption>
      <div ref={host} role="img" aria-labelledby={id} />
      <details>
        <summary>As a table</summary>
        <Scroll label={`${title}, table`} tall><table>
          <thead><tr><th className="number">{xLabel}</th>{series.map((one) => <th key={one.name} className="number">{one.name}</th>)}</tr></thead>
          <tbody>{x.map((at, i) => (
            <tr key={i}><td className="number">{Number(at.toPrecision(5))}</td>
              {series.map((one) => <td key={one.name} className="number">{one.values[i]?.toFixed(1) ?? "–"}</td>)}</tr>))}
          </tbody>
        </table></Scroll>
      </details>
    </figure>
  );
}
