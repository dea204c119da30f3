import { useEffect, useRef, useState } from "react";
import { Busy, Card } from "../ui/parts";
import { BedMap } from "./map";
import { goodExaggeration, heightOf, highestScrew, isMoved, mostResidual, touchesOf, type BedStatus, type BedTilt, type Plane } from "./maths";
import type { Label, Scene, Shown } from "./scene";
import type { Live } from "./use_bed";

function hasWebGl(): boolean {
  try {
    return document.createElement("canvas").getContext("webgl2") !== null;
  } catch {
    return false;
  }
}

function cornersOf(plane: Plane, status: BedStatus): number[] {
  const [width = 0, depth = 0] = status.travel_mm;
  return [[0, 0], [width, 0], [0, depth], [width, depth]].map(([x = 0, y = 0]) => heightOf(plane, x, y));
}

function liveScene(live: Live, status: BedStatus): Omit<Shown, "exaggeration"> {
  return {
    status, plane: null, touches: live.touches, residuals: null, mostResidual: 1, offsets: null,
    level: Math.max(...live.touches.map((touch) => touch.z)),
  };
}

function foundScene(bed: BedTilt, status: BedStatus): Omit<Shown, "exaggeration"> {
  const highest = highestScrew(bed, status.screws);
  const residuals = bed.residuals_mm ?? [];
  return {
    status, plane: bed.plane_equation, touches: touchesOf(bed),
    residuals: bed.measured_points > 3 ? residuals : null,
    mostResidual: mostResidual(residuals), offsets: bed.z_offsets,
    level: highest ? heightOf(bed.plane_equation, highest.at_mm[0]!, highest.at_mm[1]!) : 0,
  };
}

// Plane and touches as the screws have moved them since.
function movedScene(bed: BedTilt, status: BedStatus): Omit<Shown, "exaggeration"> {
  const scene = foundScene(bed, status);
  const now = bed.plane_now;
  if (!isMoved(bed.applied) || !now) return scene;
  const lifted = scene.touches.map(({ x, y, z }) => ({
    x, y, z: z + heightOf(now, x, y) - heightOf(bed.plane_equation, x, y),
  }));
  return { ...scene, plane: now, touches: lifted, offsets: null };
}

export function BedView({ status, bed, live }: { status: BedStatus; bed: BedTilt | null; live: Live | null }) {
  const [chosen, setChosen] = useState<number | null>(null);
  const [asTouched, setAsTouched] = useState(false);
  const isLive = live !== null && live.touches.length > 0;
  const hasMoved = !isLive && isMoved(bed?.applied);
  const scene = isLive ? liveScene(live, status)
    : bed && hasMoved && !asTouched ? movedScene(bed, status)
    : bed ? foundScene(bed, status)
    : { status, plane: null, touches: [], residuals: null, mostResidual: 1, offsets: null, level: 0 };
  // By the bed as touched, so that a level bed looks level beside it.
  const heights = isLive ? live.touches.map((touch) => touch.z)
    : bed ? cornersOf(bed.plane_equation, status) : [];
  const exaggeration = chosen ?? goodExaggeration(heights, status.travel_mm[0]!);
  const [isFlat] = useState(() => !hasWebGl());
  const shown = { ...scene, exaggeration };
  return (
    <Card title={isFlat ? "The bed from above" : "The bed in 3D"}>
      {isFlat ? <p className="hint">This browser draws nothing in 3D (no WebGL). Heights in mm.</p> : null}
      {isFlat ? <BedMap shown={shown} /> : <Solid shown={shown} />}
      <div className="bed-view-tools">
        {isFlat ? null : <Exaggeration value={exaggeration} set={setChosen} />}
        {hasMoved ? (
          <label className="inline">
            <input type="checkbox" checked={asTouched} onChange={(event) => setAsTouched(event.target.checked)} />
            as it was touched, before the screws moved
          </label>
        ) : null}
      </div>
      <Legend shown={shown} isLive={isLive} isFlat={isFlat} />
    </Card>
  );
}

function Exaggeration({ value, set }: { value: number; set: (value: number) => void }) {
  return (
    <label>Heights drawn {value} times as large
      <input type="range" min={0} max={1} step={0.01} value={Math.log(value) / Math.log(500)}
             aria-valuetext={`${value} times`}
             onChange={(event) => set(Math.max(1, Math.round(500 ** Number(event.target.value))))} />
    </label>
  );
}

function Legend({ shown, isLive, isFlat }: { shown: Shown; isLive: boolean; isFlat: boolean }) {
  const [width, depth] = shown.status.travel_mm;
  const most = (shown.mostResidual * 1000).toFixed(0);
  return (
    <ul className="bed-legend">
      {isFlat ? null : (
        <li><span className="bed-key frame" aria-hidden="true" /> the travel, {width} × {depth} mm, at the height of the highest {isLive ? "touch so far" : "screw"}</li>
      )}
      {shown.plane && !isFlat ? <li><span className="bed-key plane" aria-hidden="true" /> the fitted plane</li> : null}
      {shown.residuals ? (
        <li><span className="bed-key ramp" aria-hidden="true" /> touches: blue {most} µm below the plane, grey on it, orange {most} µm above</li>
      ) : shown.touches.length > 0 ? <li><span className="bed-key dot" aria-hidden="true" /> touches</li> : null}
    </ul>
  );
}

const turns: Record<string, [number, number]> = {
  ArrowLeft: [-0.12, 0], ArrowRight: [0.12, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1],
};

function useScene(shown: Shown) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const scene = useRef<Scene | null>(null);
  const latest = useRef(shown);
  latest.current = shown;
  const [labels, setLabels] = useState<Label[]>([]);
  const [state, setState] = useState<"loading" | "drawn" | "failed">("loading");
  useEffect(() => {
    let gone = false;
    import("./scene").then(({ makeScene }) => {
      if (gone || !canvas.current) return;
      scene.current = makeScene(canvas.current, setLabels);
      scene.current.show(latest.current);
      scene.current.home();
      setState("drawn");
    }).catch(() => setState("failed"));
    return () => {
      gone = true;
      scene.current?.free();
      scene.current = null;
    };
  }, []);
  const drawn = JSON.stringify(shown);
  useEffect(() => scene.current?.show(latest.current), [drawn]);
  return { canvas, scene, labels, state };
}

function Solid({ shown }: { shown: Shown }) {
  const { canvas, scene, labels, state } = useScene(shown);
  const onKey = (event: React.KeyboardEvent) => {
    const turn = turns[event.key];
    if (turn) scene.current?.turn(...turn);
    else if (event.key === "+" || event.key === "=") scene.current?.zoom(0.9);
    else if (event.key === "-") scene.current?.zoom(1.1);
    else if (event.key === "Home") scene.current?.home();
    else return;
    event.preventDefault();
  };
  if (state === "failed") return <BedMap shown={shown} />;
  return (
    <>
      <div className="bed-view" tabIndex={0} role="application" onKeyDown={onKey}
           aria-label="The bed in three dimensions. Arrow keys turn it, plus and minus zoom, Home goes back. The table of touches has the same numbers.">
        <canvas ref={canvas} aria-hidden="true" />
        <div aria-hidden="true">
          {labels.map((label) => (
            <span key={label.text} className={label.className}
                  style={{ transform: `translate(-50%, -100%) translate(${label.left}px, ${label.top}px)` }}>{label.text}</span>
          ))}
        </div>
        {state === "loading" ? <Busy text="Loading the drawing" /> : null}
      </div>
      <div className="bed-view-hint">
        <span className="hint">Drag or arrow keys turn it; + and − zoom.</span>
        <button type="button" className="quiet" onClick={() => scene.current?.home()}>Reset the view</button>
      </div>
    </>
  );
}
