import { useEffect, useRef, useState, type ReactNode } from "react";
import { Busy, Notice } from "../ui/parts";
import type { SceneData } from "./data";
import type { Shape } from "./use_shape";
import type { World } from "./world";

function hasWebGl(): boolean {
  try {
    return document.createElement("canvas").getContext("webgl2") !== null;
  } catch {
    return false;
  }
}

const turns: Record<string, [number, number]> = {
  ArrowLeft: [-0.12, 0], ArrowRight: [0.12, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1],
};

function useWorld(data: SceneData | null, onWorld: (world: World | null) => void) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const [world, setWorld] = useState<World | null>(null);
  const [hasFailed, setFailed] = useState(false);
  const shown = useRef("");
  useEffect(() => {
    let gone = false;
    let made: World | null = null;
    import("./world").then(({ makeWorld }) => {
      if (gone || !canvas.current) return;
      made = makeWorld(canvas.current);
      setWorld(made);
    }).catch(() => setFailed(true));
    return () => {
      gone = true;
      onWorld(null);
      shown.current = "";
      made?.free();
    };
  }, [onWorld]);
  useEffect(() => {
    if (!world || !data) return;
    const size = JSON.stringify([data.machine, data.travel_mm]);
    world.show(data, shown.current === size);
    shown.current = size;
    onWorld(world);
  }, [world, data, onWorld]);
  return { canvas, world, hasFailed };
}

function Solid({ data, name, told, onWorld, onFailed }: {
  data: SceneData | null;
  name: string;
  told: string;
  onWorld: (world: World | null) => void;
  onFailed: () => void;
}) {
  const { canvas, world, hasFailed } = useWorld(data, onWorld);
  useEffect(() => { if (hasFailed) onFailed(); }, [hasFailed, onFailed]);
  const onKey = (event: React.KeyboardEvent) => {
    const turn = turns[event.key];
    if (turn) world?.turn(...turn);
    else if (event.key === "+" || event.key === "=") world?.zoom(0.9);
    else if (event.key === "-") world?.zoom(1.1);
    else if (event.key === "Home") world?.home();
    else return;
    event.preventDefault();
  };
  return (
    <>
      <div className="mac-view" tabIndex={0} role="application" onKeyDown={onKey}
           aria-label={`${name} in three dimensions. Arrow keys turn it, plus and minus zoom, Home goes back. ${told}`}>
        <canvas ref={canvas} aria-hidden="true" data-drawn={world && data ? data.machine : undefined} />
        {!world || !data ? <Busy text="Loading the machine" /> : null}
      </div>
      <div className="mac-view-hint">
        <span className="hint">Drag, or use the arrow keys, to turn it. + and − zoom; so does the wheel after a click.</span>
        <button type="button" className="quiet" onClick={() => world?.home()}>Reset the view</button>
      </div>
    </>
  );
}

function Still({ machine, picture, children }: { machine: string; picture: string | null; children: ReactNode }) {
  const [isMissing, setMissing] = useState(false);
  return (
    <>
      {isMissing || !picture ? null : <img className="mac-picture" src={picture} alt={`The machine ${machine}, standing still`} onError={() => setMissing(true)} />}
      {children}
    </>
  );
}

function Undrawn({ shape, machine, picture }: { shape: Drawing; machine: string; picture: string | null }) {
  return (
    <Still machine={machine} picture={picture}>
      <Notice kind="info">
        <p><strong>This machine is not drawn in 3D.</strong> The server says: {shape.problem?.detail}.</p>
        {shape.problem?.status === 422 ? null : <p><button type="button" className="quiet" onClick={shape.again}>Try again</button></p>}
      </Notice>
    </Still>
  );
}

export type Drawing = Pick<Shape, "data" | "problem" | "again">;

const inCode = "What it does is in the list of G-code.";

// In 3D; as a picture where the browser draws none. `children` belong to the drawing in 3D.
export function MachineView({ shape, machine, picture, told = inCode, onWorld, children }: {
  shape: Drawing;
  machine: string;
  picture: string | null;
  // Where the same stands in words.
  told?: string;
  onWorld: (world: World | null) => void;
  children?: ReactNode;
}) {
  const [isFlat, setFlat] = useState(() => !hasWebGl());
  if (isFlat) {
    return (
      <Still key={machine} machine={machine} picture={picture}>
        <p className="hint">This browser draws nothing in 3D (no WebGL), so the machine does not move here. The list of G-code follows the run all the same.</p>
      </Still>
    );
  }
  if (shape.problem && !shape.data) return <Undrawn key={machine} shape={shape} machine={machine} picture={picture} />;
  return (
    <>
      <Solid data={shape.data} name={machine} told={told} onWorld={onWorld} onFailed={() => setFlat(true)} />
      {shape.problem ? (
        <Notice kind="warn"><p><strong>Not drawn anew: {shape.problem.detail}.</strong> The drawing before is still shown.
          {shape.problem.errors?.some((fault) => fault.file === "--exaggerate") ? " Choose smaller errors." : ""}</p></Notice>
      ) : null}
      {children}
    </>
  );
}

const most = 300;

export function Exaggeration({ value, set }: { value: number; set: (value: number) => void }) {
  const [shown, setShown] = useState(value);
  const timer = useRef(0);
  useEffect(() => setShown(value), [value]);
  const change = (next: number) => {
    setShown(next);
    clearTimeout(timer.current);
    timer.current = window.setTimeout(() => set(next), 250);
  };
  return (
    <label className="mac-slider">Errors drawn {shown === 1 ? "as they are (1×)" : `${shown} times as large`}
      <input type="range" min={0} max={1} step={0.01} value={Math.log(shown) / Math.log(most)}
             aria-valuetext={`${shown} times`}
             onChange={(event) => change(Math.max(1, Math.round(most ** Number(event.target.value))))} />
    </label>
  );
}
