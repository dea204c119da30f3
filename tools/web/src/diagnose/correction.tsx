import { useEffect, useId, useState } from "react";
import { answered, api, problemOf, type Problem, type Schemas } from "../api/client";
import { Busy, Card, Notice, withSd } from "../ui/parts";
import type { Diagnosis, Fact } from "./types";
import { axisWord, nice } from "./words";

const controllers = [
  ["rrf", "RepRapFirmware"], ["klipper", "Klipper"], ["marlin", "Marlin"], ["linuxcnc", "LinuxCNC"],
] as const;
type Controller = (typeof controllers)[number][0];

function CopyButton({ text }: { text: string }) {
  const [done, setDone] = useState("");
  const copy = () => {
    const failed = () => setDone("Copying failed. Select the text and copy it by hand.");
    // Absent on pages that are neither https nor of this computer.
    if (!navigator.clipboard) { failed(); return; }
    navigator.clipboard.writeText(text).then(() => setDone("Copied."), failed);
  };
  return (
    <p className="row">
      <button type="button" onClick={copy}>Copy</button>
      <span role="status">{done}</span>
    </p>
  );
}

// `hasSteps`: the lines with the new steps/mm stand above already.
function WhyNot({ problem, hasSteps }: { problem: Problem; hasSteps: boolean }) {
  if (hasSteps && problem.status === 422) {
    return (
      <Notice kind="info">
        <p><strong>The line above is all there is to paste.</strong> A whole file of settings needs a machine file that has your
          steps/mm; the list under “Change what was assumed” may have your machine.</p>
      </Notice>
    );
  }
  return (
    <Notice kind={problem.status === 422 ? "info" : "bad"}>
      <p><strong>No settings to paste:</strong> {problem.detail}.</p>
      {/steps\/mm/.test(problem.detail)
        ? <p>If one of the machines under “Change what was assumed” has your steps/mm, choose it there. Or use the factor above.</p>
        : problem.errors?.map((fault, i) => (fault.hint ? <p key={i} className="hint">{nice(fault.hint)}</p> : null))}
    </Notice>
  );
}

// The factor needs no machine file: what stands in the firmware, times what was measured.
// One line that sets them, as each firmware has it.
function stepsLines(axis: string, steps: string): [string, string][] {
  const letter = axis.toUpperCase();
  return [
    ["Marlin, RepRapFirmware", `M92 ${letter}${steps}`],
    ["grbl", `$${100 + "XYZ".indexOf(letter)}=${steps}`],
    ["LinuxCNC, in its joint's section", `SCALE = ${steps}`],
  ];
}

export const stepsIn = (text: string) => Number(text.replace(",", "."));

function NewSteps({ fact, now, setNow }: { fact: Fact; now: string; setNow: (now: string) => void }) {
  const id = useId();
  const axis = axisWord(fact.axis);
  const factor = fact.steps_factor ?? 1;
  const steps = stepsIn(now);
  return (
    <div>
      <p>Multiply the steps/mm of {axis} by {withSd(factor, fact.steps_factor_sd, "", 6).trim()}. Klipper: divide rotation_distance by it.</p>
      <div className="row">
        <label htmlFor={id}>Steps/mm of {axis} set now
          <input id={id} inputMode="decimal" value={now} placeholder="80" onChange={(event) => setNow(event.target.value)} />
        </label>
        <output htmlFor={id}>
          {steps > 0 ? <>Set {withSd(steps * factor, fact.steps_factor_sd ? steps * fact.steps_factor_sd : null, "steps/mm")}</> : null}
        </output>
      </div>
      {steps > 0 && "xyz".includes(fact.axis) && fact.axis ? (
        <div className="scroll">
          <table aria-label="The line that sets them">
            <tbody>
              {stepsLines(fact.axis, (steps * factor).toFixed(3)).map(([name, line]) => (
                <tr key={name}><th scope="row">{name}</th><td><code>{line}</code></td></tr>
              ))}
            </tbody>
          </table>
        </div>
      ) : null}
    </div>
  );
}

const isOff = (fact: Fact) => fact.fact === "scale" && fact.is_answer && typeof fact.steps_factor === "number";
const setsNothing = (text: string) => text.split("\n").every((line) => /^\s*($|[;#[])/.test(line));

// `stepsNow`: the steps/mm set now, as said under “Change what was assumed”.
export function Correction({ one, stepsNow }: { one: Diagnosis; stepsNow: string }) {
  const id = one.id;
  const [controller, setController] = useState<Controller | "">("");
  const [found, setFound] = useState<Schemas["Correction"] | null>(null);
  const [problem, setProblem] = useState<Problem | null>(null);
  // By axis, as typed.
  const [steps, setSteps] = useState<Record<string, string>>({});
  const off = (one.not_the_machine ? [] : one.facts ?? []).filter(isOff);
  const hasSteps = off.length > 0 && off.every((fact) => stepsIn(steps[fact.axis] ?? stepsNow) > 0);
  useEffect(() => {
    setFound(null);
    setProblem(null);
    if (!controller) return;
    let current = true;
    answered(api.GET("/api/diagnoses/{id}/correction", { params: { path: { id }, query: { for: controller } } }))
      .then((one) => current && setFound(one), (error: unknown) => current && setProblem(problemOf(error)));
    return () => { current = false; };
  }, [id, controller]);
  return (
    <Card title="Settings to paste">
      {off.map((fact) => (
        <NewSteps key={fact.says} fact={fact} now={steps[fact.axis] ?? stepsNow} setNow={(now) => setSteps((all) => ({ ...all, [fact.axis]: now }))} />
      ))}
      <label>Your controller
        <select value={controller} onChange={(event) => setController(event.target.value as Controller | "")}>
          <option value="">choose</option>
          {controllers.map(([key, name]) => <option key={key} value={key}>{name}</option>)}
        </select>
      </label>
      {controller && !found && !problem ? <Busy text="Working out the settings" /> : null}
      {problem ? <WhyNot problem={problem} hasSteps={hasSteps} /> : null}
      {found?.files.map((file) => (
        <div key={file.name}>
          <h3>{file.name}</h3>
          {setsNothing(file.text) ? <p>Nothing to set here. The comments say why.</p> : null}
          <pre tabIndex={0} aria-label={`Settings, ${file.name}`}>{file.text}</pre>
          <CopyButton text={file.text} />
        </div>
      ))}
    </Card>
  );
}
