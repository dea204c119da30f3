import "../machine/machine.css";
import { useCallback, useEffect, useMemo, useState } from "react";
import { picturePath, posesOf, type Subject } from "../machine/ask";
import type { SceneData } from "../machine/data";
import { useShape, type Shape } from "../machine/use_shape";
import { MachineView } from "../machine/view";
import type { World } from "../machine/world";
import { alongOf, commanded, isBeside, marksOf, middleOf, mostOf, placesOf, plainScene, sizeOf, stepInLine, untold, type Triple } from "./places";
import { hasOwnMachine, type Diagnosis, type PlaceError } from "./types";
import { plain, size } from "./words";

const nothing = (): void => undefined;

// `longest_mm`: as long as the longest arrow is at first; `bends`: whether lines are bent.
interface Fitted { places: PlaceError[]; outside: number; size_mm: number; longest_mm: number; bends: boolean }

// Puts the errors on what is drawn; with a machine at the places that its tip reaches.
function useErrors(places: PlaceError[], subject: Subject | null, data: SceneData | null, world: World | null): Fitted | null {
  const [fitted, setFitted] = useState<Fitted | null>(null);
  useEffect(() => {
    if (!world || !data) return;
    const control = new AbortController();
    const draw = (at: (Triple | null)[]) => {
      const there = places.filter((_, i) => at[i]);
      const where = at.filter((one) => one !== null);
      const size_mm = sizeOf(where);
      const step_mm = stepInLine(there, where);
      world.mark(marksOf(places, at), size_mm);
      setFitted({ places: there, outside: places.length - there.length, size_mm, longest_mm: step_mm ? 0.85 * step_mm : 0.15 * size_mm, bends: step_mm === null });
    };
    if (!subject || !data.moves) {
      draw(commanded(places, [0, 0, 0]));
      return;
    }
    const ask = async () => {
      const at = commanded(places, middleOf(data));
      const found: (Triple | null)[] = [];
      for (let i = 0; i < at.length; i += 400) {
        const came = await posesOf(subject, at.slice(i, i + 400), control.signal);
        found.push(...world.tips(came.bodies, came.poses));
        const first = came.poses.find((pose) => pose !== null);
        if (first) world.move(came.bodies, first);
      }
      if (!control.signal.aborted) draw(found);
    };
    // Without an answer the machine is shown as it stands, without errors.
    ask().catch(() => { if (!control.signal.aborted) setFitted(null); });
    return () => control.abort();
  }, [places, subject, data, world]);
  return fitted;
}

function Legend({ fitted, one, machine }: { fitted: Fitted; one: Diagnosis; machine: string }) {
  const { places, outside } = fitted;
  const along = alongOf(places);
  const isTouch = places.every((place) => place.is_touch);
  const missing = untold(places);
  return (
    <>
      <p>
        Each arrow stands at a measured place. It shows {isTouch ? "where the surface seems to be off" : "how far the machine is off there"}
        {one.show?.places_of === "findings" ? " because of what was found. Plain settings (steps/mm, backlash, where things lie) are left out" : " because of plain settings (steps/mm, backlash, tilt), counted from the mean of all places"}.
        {fitted.bends ? " The green line joins the ends of the arrows: without errors it would lie on the grey one." : ""}
      </p>
      <ul className="error-legend">
        <li><span className="error-key plus" aria-hidden="true" />{along ? `orange: towards +${along}` : "orange: along the direction measured"}</li>
        <li><span className="error-key minus" aria-hidden="true" />{along ? `blue: towards −${along}` : "blue: against it"}</li>
        <li>Largest: {size(mostOf(places))}</li>
        {isBeside(places) ? <li>Readings taken while moving in the − direction are drawn a little to the side.</li> : null}
      </ul>
      {missing.length > 0 ? <p className="hint">The file does not tell {missing.join(" and ")}{machine ? ": drawn in the middle of the travel" : ""}.</p> : null}
      {outside > 0 ? <p className="hint">{outside} places are beyond the travel of this machine, so they are not drawn. Is it the right one?</p> : null}
      <p className="hint">{machine ? `The machine is the ${plain(machine)}, as you chose it. Only the arrows come from your file.`
        : hasOwnMachine(one) ? "The machine that the file describes is not drawn, only the places: the plate reaches as far as the measurements do."
          : "No machine is named, so only the places are drawn: the plate reaches as far as the measurements do."}{" "}
        {machine ? null : <a href="#assumed">Choose your machine</a>}</p>
    </>
  );
}

// Round numbers, evenly on a logarithmic slider.
const rounded = (times: number) => Number(Math.max(1, times).toPrecision(2));

function Times({ value, most, set }: { value: number; most: number; set: (value: number) => void }) {
  return (
    <label className="mac-slider">Error drawn {value === 1 ? "as it is (1 time)" : `${value.toLocaleString()} times as large`}
      <input type="range" min={0} max={1} step={0.01} value={Math.log(value) / Math.log(most)} aria-valuetext={`${value} times`}
             onChange={(event) => set(rounded(most ** Number(event.target.value)))} />
    </label>
  );
}

export default function DrawnErrors({ one, machine }: { one: Diagnosis; machine: string }) {
  const places = useMemo(() => placesOf(one), [one]);
  const subject = useMemo<Subject | null>(() => (machine ? { of: "machines", name: machine, exaggerate: 1 } : null), [machine]);
  const asked = useShape(subject);
  const bare = useMemo(() => plainScene(commanded(places, [0, 0, 0])), [places]);
  const isPlain = !subject || asked.problem !== null || asked.data?.moves === false;
  const shape: Shape = isPlain ? { data: bare, of: null, isLoading: false, problem: null, again: nothing } : asked;
  const [world, setWorld] = useState<World | null>(null);
  const onWorld = useCallback((next: World | null) => setWorld(next), []);
  const fitted = useErrors(places, isPlain ? null : subject, shape.data, world);
  const [chosen, setChosen] = useState<number | null>(null);
  const largest_mm = mostOf(fitted?.places ?? places) / 1000;
  const most = fitted ? Math.max(10, (0.5 * fitted.size_mm) / largest_mm) : 10;
  const times = chosen ?? (fitted ? rounded(fitted.longest_mm / largest_mm) : 1);
  useEffect(() => { if (fitted) world?.exaggerate(times); }, [world, fitted, times]);
  return (
    <MachineView shape={shape} machine={isPlain ? "The measured places" : plain(machine)} picture={isPlain ? null : picturePath(machine)} told="The figures are in the text of this answer." onWorld={onWorld}>
      {fitted ? <Times value={times} most={most} set={setChosen} /> : null}
      {fitted ? <Legend fitted={fitted} one={one} machine={isPlain ? "" : machine} /> : null}
    </MachineView>
  );
}
