import { capital, plain } from "../calibrate/words";
import { Card, Notice, withSd } from "../ui/parts";
import { transcriptPath } from "./ask";
import { checkName, quantityName, unitWord, withUnit } from "./names";
import type { Done } from "./use_run";

interface Parameter {
  name: string;
  unit: string;
  injected: number | null;
  recovered: number | null;
  sd: number | null;
  tolerance: number | null;
  passed: boolean | null;
  identifiable: boolean;
}

interface Check { name: string; expected: string; found: string; passed: boolean }

export interface RunResult {
  passed: boolean;
  outcome: string;
  machine: string;
  seed: number;
  touches: number;
  machine_time_s: number;
  parameters: Parameter[];
  checks: Check[];
  messages: string[];
  causes: string[];
  steps: { message: string }[];
}

const outcomes: Record<string, string> = {
  recovers: "The procedure finds the hidden errors it looks for.",
  misses: "The procedure misses: what it tells or leaves behind is not right.",
  diverges: "The procedure makes the machine worse.",
  alarm: "The machine stopped itself with an alarm.",
  collision: "The stylus collided.",
  no_trigger: "A probe move ended without touching what it was to find.",
  refused: "The procedure was refused, by a limit or a check before it.",
  reads_zero: "The procedure reads zero where there is an error.",
  confounded: "The procedure says that it cannot tell the errors apart.",
};
const outcomeOf = (outcome: string) => outcomes[outcome] ?? `The run ended so: ${outcome.replaceAll("_", " ")}.`;

const sentence = (text: string) => capital(plain(text.trim())).replace(/([^.!?])$/, "$1.");
const once = (texts: string[]) => [...new Set(texts)];

// What went wrong and why, as the procedures name it.
const namedIn = (result: RunResult) => once(result.causes.map(sentence));

export function Verdict({ result, isLinked }: { result: RunResult; isLinked?: boolean }) {
  const named = namedIn(result);
  const failed = result.checks.filter((check) => !check.passed).length;
  const expected = result.passed
    ? "That is what this scenario expects."
    : `${failed} of ${result.checks.length} checks of this scenario failed.`;
  const kind = !result.passed ? "bad" : result.outcome === "recovers" ? "good" : "warn";
  const isNamed = named.length > 0;
  return (
    <Notice kind={kind}>
      {named.map((text) => <p key={text}><strong>{text}</strong></p>)}
      <p>{isNamed ? null : <strong>{outcomeOf(result.outcome)} </strong>}
        {isNamed && result.outcome !== "recovers" ? `${outcomeOf(result.outcome)} ` : null}{expected}
        {isLinked ? <> <a href="#result">The numbers are below.</a></> : null}</p>
    </Notice>
  );
}

// What the procedure said besides, in its order.
function Said({ result }: { result: RunResult }) {
  const named = namedIn(result);
  const rest = once(result.messages.map(sentence)).filter((text) => !named.includes(text));
  if (rest.length === 0) return null;
  return (
    <>
      <h3>{named.length > 0 ? "What the procedure said besides" : "What the procedure said"}</h3>
      <ul>{rest.map((text) => <li key={text}>{text}</li>)}</ul>
    </>
  );
}

function told(one: Parameter): string {
  if (one.recovered === null) return "not known";
  if (!one.identifiable) return `not known (read ${withSd(one.recovered, one.sd, unitWord(one.unit), 4)})`;
  return one.sd ? withSd(one.recovered, one.sd, unitWord(one.unit)) : `${withSd(one.recovered, null, unitWord(one.unit), 4)} (uncertainty not known)`;
}

function judged(one: Parameter): string {
  if (one.passed === null) return "not judged";
  if (!one.identifiable && one.passed) return "✓ passed: it cannot be told, and the run says so";
  const limit = one.tolerance === null ? "" : `, tolerance ± ${one.tolerance} ${unitWord(one.unit)}`;
  return (one.passed ? "✓ passed" : "✗ failed") + limit;
}

const digitsFor = (one: Parameter) => (one.sd ? Math.max(0, Math.min(6, 1 - Math.floor(Math.log10(one.sd)))) : 4);

function Parameters({ all }: { all: Parameter[] }) {
  return (
    <>
      <h3>Errors, built in and found</h3>
      <div className="scroll mac-table" tabIndex={0} role="group" aria-label="Errors, built in and found">
        <table>
          <thead><tr><th scope="col">Quantity</th><th scope="col" className="number">Built in</th>
            <th scope="col" className="number">Found (± standard uncertainty)</th><th scope="col">Judged</th></tr></thead>
          <tbody>
            {all.map((one) => (
              <tr key={one.name}>
                <th scope="row">{quantityName(one.name)}</th>
                <td className="number">{one.injected === null ? "none" : `${one.injected.toFixed(digitsFor(one))} ${unitWord(one.unit)}`}</td>
                <td className="number">{told(one)}</td>
                <td className={one.passed === null ? "hint" : one.passed ? "mac-good" : "mac-bad"}>{judged(one)}</td>
              </tr>
            ))}
          </tbody>
        </table>
      </div>
    </>
  );
}

const checkWords: Record<string, string> = {
  recovers: "errors found", misses: "errors missed", diverges: "made worse", reads_zero: "reads zero", no_trigger: "nothing touched", confounded: "cannot be told apart",
};

function CheckRow({ check }: { check: Check }) {
  const { title, unit } = checkName(check.name);
  const inWords = (text: string) => withUnit(checkWords[text] ?? text, unit);
  const isSentence = check.name === "message";
  return (
    <tr>
      <th scope="row">{title}</th><td>{isSentence ? `“${check.expected}”` : inWords(check.expected)}</td><td>{inWords(check.found)}</td>
      <td className={check.passed ? "mac-good" : "mac-bad"}>{check.passed ? "✓ passed" : "✗ failed"}</td>
    </tr>
  );
}

// Words that were waited for and stand at the top, in the cause, are not listed again.
function Checks({ all, causes }: { all: Check[]; causes: string[] }) {
  const isAtTop = (check: Check) => check.name === "message" && check.passed &&
    causes.some((cause) => cause.includes(check.expected));
  const shown = all.filter((check) => !isAtTop(check));
  if (shown.length === 0) return null;
  return (
    <>
      <h3>Checks of the scenario</h3>
      <div className="scroll mac-table" tabIndex={0} role="group" aria-label="Checks of the scenario">
        <table>
          <thead><tr><th scope="col">Check</th><th scope="col">Expected</th><th scope="col">Found</th><th scope="col">Judged</th></tr></thead>
          <tbody>{shown.map((check, i) => <CheckRow key={i} check={check} />)}</tbody>
        </table>
      </div>
    </>
  );
}

function Ended({ done }: { done: Done }) {
  if (done.state === "stopped") {
    return <Notice kind="warn"><p><strong>The run was stopped before its end.</strong> There is no result. {done.transcript ? "What it sent until then can be played." : "The server kept no transcript of it."}</p></Notice>;
  }
  if (done.state === "failed") {
    return <Notice kind="bad"><p><strong>The run failed.</strong> {done.detail || "The server gives no reason."}</p></Notice>;
  }
  return null;
}

export function Result({ done }: { done: Done }) {
  const { result } = done;
  const report = `/api/runs/${encodeURIComponent(done.id)}/report`;
  return (
    <div id="result" tabIndex={-1}>
    <Card title="Result" aside={result ? <a href={report} target="_blank" rel="noreferrer">Full report (new tab)</a> : null}>
      <Ended done={done} />
      {result ? (
        <>
          <Verdict result={result} />
          <p className="hint">{result.touches} touches in {result.machine_time_s.toFixed(0)} s of machine time. Machine: {result.machine.replaceAll("_", " ")}. Noise of seed {result.seed}.</p>
          {result.parameters.length > 0 ? <Parameters all={result.parameters} /> : <p>The run tells no parameter.</p>}
          <Checks all={result.checks} causes={result.causes} />
          <Said result={result} />
        </>
      ) : null}
      {done.transcript ? <p><a href={transcriptPath(done.id)} target="_blank" rel="noreferrer">Whole transcript (new tab)</a></p> : null}
    </Card>
    </div>
  );
}
