import type { ReactNode } from "react";
import { Notice } from "../ui/parts";
import { isDeclined, type Job, type Result } from "./model";
import { capital, endingOf, jobName, plain, valueOf } from "./words";

const verdicts: Record<string, string> = {
  measured: "kept as it was", applied: "applied", refused: "refused, not applied", rolled_back: "taken back, it was worse",
};

// A job that was stopped keeps what it applied, and no estimate of how sure that is.
function readingsSay(step: Result["steps"][number], found: Result["estimates"][number] | undefined): string {
  if (found?.is_known) return valueOf(step.name, found.value, found.sd);
  return !found && step.verdict === "applied" ? `${valueOf(step.name, step.after)}, uncertainty not known` : "not known";
}

function Changes({ result, name }: { result: Result; name: string }) {
  if (result.steps.length === 0 && result.estimates.length === 0) return null;
  return (
    <div className="scroll" tabIndex={0} role="region" aria-label={`Values: ${name}`}>
      <table>
        <thead>
          <tr><th scope="col">Setting</th><th scope="col">Before</th><th scope="col">Now</th>
            <th scope="col">The readings say</th><th scope="col">What was done</th></tr>
        </thead>
        <tbody>
          {result.steps.map((step, i) => {
            const found = result.estimates.find((one) => one.name === step.name);
            return (
              <tr key={i}>
                <th scope="row">{plain(step.name)}</th>
                <td>{valueOf(step.name, step.before)}</td>
                <td>{valueOf(step.name, step.after)}</td>
                <td>{readingsSay(step, found)}</td>
                <td className="cal-told">{capital(verdicts[step.verdict] ?? step.verdict)}. {capital(plain(step.message))}</td>
              </tr>
            );
          })}
          {result.estimates.filter((one) => !result.steps.some((step) => step.name === one.name)).map((one) => (
            <tr key={one.name}>
              <th scope="row">{plain(one.name)}</th><td>–</td><td>unchanged</td>
              <td>{one.is_known ? valueOf(one.name, one.value, one.sd) : "not known"}</td><td>Nothing was changed.</td>
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}

interface Verdict { kind: "good" | "warn" | "bad"; text: string; remedy: string }

function refusedOf(result: Result): Verdict | null {
  if (isDeclined(result)) {
    return { kind: "warn", text: "Measured, and not applied, as you said.", remedy: "Repeat the step to apply it after all." };
  }
  if (result.machine_said?.startsWith("the operator")) {
    return { kind: "warn", text: "Stopped, because the question was not answered. Nothing was changed.",
      remedy: "Repeat the step when you can answer it." };
  }
  const bad = result.steps.find((step) => step.verdict === "refused" || step.verdict === "rolled_back");
  if (bad?.verdict === "rolled_back") {
    return { kind: "warn", text: "Applied, then taken back: the check afterwards was worse.",
      remedy: "Look for loose parts and friction. Steps/mm that are more than 5 % wrong do this too." };
  }
  return bad ? { kind: "warn", text: "Measured, but not applied.", remedy: endingOf("refused").remedy } : null;
}

export function verdictOf(result: Result): Verdict {
  const refused = refusedOf(result);
  if (refused) return refused;
  const ending = endingOf(result.ending);
  const applied = result.steps.filter((step) => step.verdict === "applied").at(-1);
  const isStopped = result.ending === "aborted" || result.ending === "interrupted";
  if (isStopped && !applied) return { kind: ending.kind, text: ending.verdict, remedy: "Nothing was changed. Measure again when you are ready." };
  if (result.ending !== "done") return { kind: ending.kind, text: ending.verdict, remedy: ending.remedy };
  if (applied) {
    const sd = result.estimates.find((one) => one.name === applied.name)?.sd;
    return { kind: "good", text: `${plain(applied.name)} is now ${valueOf(applied.name, applied.after, sd)}.`, remedy: "" };
  }
  return { kind: "good", text: result.steps.length > 0 ? "What is set agrees with the measurement. Nothing had to change." : "Done.", remedy: "" };
}

export function JobResult({ job, hideChanges, children }: { job: Job; hideChanges?: boolean; children?: ReactNode }) {
  const { result } = job;
  if (!result) return null;
  const verdict = verdictOf(result);
  const messages = [...new Set(result.messages)].filter((text) => !result.machine_said || !text.includes(result.machine_said));
  const failed = verdict.kind !== "good" && !isDeclined(result) && result.ending !== "aborted" && !result.machine_said?.startsWith("the operator");
  const told = <ul>{messages.map((text) => <li key={text}>{plain(text)}</li>)}</ul>;
  return (
    <div>
      <h3>{jobName(job)}</h3>
      <Notice kind={verdict.kind}>
        <p><strong>{capital(verdict.text)}</strong></p>
        {verdict.remedy ? <p>{verdict.remedy}</p> : null}
        {failed && result.machine_said ? <p>The controller answered: <q>{result.machine_said}</q></p> : null}
        {failed && messages.length > 0 ? told : null}
      </Notice>
      {hideChanges ? null : <Changes result={result} name={jobName(job)} />}
      {!failed && messages.length > 0 ? (
        <details><summary>What these measurements tell, and what not</summary>{told}</details>
      ) : null}
      {children}
    </div>
  );
}
