import { answered, api, problemOf, type Problem } from "../api/client";
import { stepsIn } from "./correction";
import { first } from "./words";
import { diagnosesOf, type Diagnosis } from "./types";

export interface Assumed { machine: string; unit: "" | "mm" | "um" | "inch" | "thou"; axis: "" | "x" | "y" | "z"; least: string; steps: string; columns: string }
export const nothingAssumed: Assumed = { machine: "", unit: "", axis: "", least: "", steps: "", columns: "" };

// Another assumption about the same files that was refused: the answer before stays.
export interface Refused { assumed: Assumed; problems: Problem[] }

export interface Answer {
  key: number;
  at: Date;
  files: File[];
  assumed: Assumed;
  diagnoses: Diagnosis[];
  problems: Problem[];
}

function send(files: File[], assumed: Assumed, signal: AbortSignal) {
  const form = new FormData();
  for (const file of files) form.append("file", file);
  if (assumed.machine) form.append("machine", assumed.machine);
  if (assumed.unit) form.append("unit", assumed.unit);
  if (assumed.axis) form.append("axis", assumed.axis);
  if (assumed.least.trim()) form.append("min_effect_um", assumed.least.trim());
  const steps = stepsIn(assumed.steps);
  if (steps > 0) form.append("step_mm", String(1 / steps));
  if (assumed.columns) form.append("map", assumed.columns);
  // The multipart body is made by the browser; the typed client knows only its fields.
  return answered(api.POST("/api/diagnose", { body: form as never, bodySerializer: () => form, signal }));
}

// The page has a form in place of the command that the hint tells.
function forPeople(problem: Problem): Problem {
  const errors = problem.errors?.map((fault) => ({ ...fault, hint: fault.hint?.replace(/ Or say it: caltwin import.*$/s, "") }));
  return { ...problem, detail: first(problem.detail), errors: errors?.map((fault) => ({ ...fault, detail: first(fault.detail) })) };
}

// A file and the header of its name.
export const withHeader = (files: File[], name: string) => files.filter((file) => stem(file.name) === stem(name));

const stem = (name: string) => name.replace(/\.[^.]*$/, "");

// One file that cannot be read does not keep the others from being answered: it is left
// out (with the header beside it) and the rest is sent again.
export async function ask(files: File[], assumed: Assumed, signal: AbortSignal): Promise<Pick<Answer, "diagnoses" | "problems">> {
  const problems: Problem[] = [];
  let rest = files;
  while (rest.length > 0) {
    try {
      return { diagnoses: diagnosesOf(await send(rest, assumed, signal)), problems };
    } catch (error) {
      const problem = forPeople(problemOf(error));
      problems.push(problem);
      const bad = problem.errors?.[0]?.file;
      const kept = bad ? rest.filter((file) => stem(file.name) !== stem(bad)) : [];
      if (problem.status !== 422 || kept.length === rest.length) break;
      rest = kept;
    }
  }
  return { diagnoses: [], problems };
}
