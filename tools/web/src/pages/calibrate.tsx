import { useEffect, useRef } from "react";
import "../calibrate/calibrate.css";
import { Measure } from "../calibrate/measure";
import { isThrough, stateOf, stepOf, steps, type Bench, type StepState } from "../calibrate/model";
import { QuestionDialog } from "../calibrate/question";
import { Report } from "../calibrate/report";
import { NowBar, Status } from "../calibrate/status";
import { useBench, type BenchHold } from "../calibrate/use_bench";
import { Welcome } from "../calibrate/welcome";
import { operatorName } from "../api/client";
import { Busy, Card, Notice, ProblemNotice, useFocusAfter } from "../ui/parts";

const stateTexts: Record<StepState, string> = {
  open: "open", running: "running", done: "done", skipped: "skipped", stopped: "needs attention",
};

// Goes on by itself after a job that this page saw running: homing leads to step 2, and an
// axis to the next that waits. A page opened later asks first (its button "Continue").
function useGoOn(hold: BenchHold) {
  const handled = useRef(0);
  const { bench, entries } = hold;
  const job = bench?.job;
  useEffect(() => {
    if (!bench || !job) return;
    if (bench.state !== "idle" || !job.result || hold.followed !== job.id || handled.current === job.id) return;
    handled.current = job.id;
    const step = stepOf(job.procedure);
    // Who ended a job wants no other axis to move by itself.
    if (job.result.ending === "aborted" && entries.queue) hold.keep({ queue: null });
    if (!isThrough(job) || !step) return;
    if (step.n === 1) {
      if (entries.step === 1) hold.keep({ step: 2 });
      return;
    }
    const queue = entries.queue;
    const [next, ...rest] = queue?.step === step.n ? queue.axes : [];
    if (!next) return;
    const options = { axis: next, ...(step.n > 2 && entries.variant === "as_published" ? { variant: entries.variant } : {}) };
    void hold.claim(queue, { queue: rest.length > 0 ? { step: step.n, axes: rest } : null })
      .then((mine) => { if (mine) void hold.run(step.procedure, options); });
  });
}

// A twin has nobody to turn its block: where the person said so, it answers by itself.
function useTwinHands(hold: BenchHold) {
  const answered = useRef(0);
  const { bench, entries } = hold;
  const question = bench?.state === "asking" ? bench.job?.question : null;
  useEffect(() => {
    if (!bench?.is_twin || bench.held_by !== operatorName() || !entries.twinHands || !question || question.kind === "confirm" || question.kind === "other") return;
    if (question.id === answered.current || (question.kind === "reading" && question.hint_mm === undefined)) return;
    answered.current = question.id;
    hold.answerQuietly(question.id, question.kind === "reading" ? question.hint_mm : undefined);
  });
}

function StepList({ hold, bench }: { hold: BenchHold; bench: Bench }) {
  return (
    <nav aria-label="Steps">
      <ol className="cal-steps">
        {steps.map((step) => {
          const state = stateOf(step, bench, hold.entries);
          return (
            <li key={step.n}>
              <button aria-current={hold.entries.step === step.n ? "step" : undefined} onClick={() => hold.keep({ step: step.n })}>
                <span>{step.n}. {step.name}</span>
                <span className={`cal-state ${state}`}>{stateTexts[state]}</span>
              </button>
            </li>
          );
        })}
      </ol>
    </nav>
  );
}

function Wizard({ hold, bench }: { hold: BenchHold; bench: Bench }) {
  useGoOn(hold);
  useTwinHands(hold);
  const step = steps[hold.entries.step - 1] ?? steps[0]!;
  const heading = useRef<HTMLHeadingElement>(null);
  useFocusAfter(step.n, heading, ".cal-now");
  return (
    <div className="cal-layout">
      <StepList hold={hold} bench={bench} />
      <div>
        {hold.problem ? (
          <div className="cal-problem"><ProblemNotice problem={hold.problem} />
            <button className="quiet" onClick={hold.clearProblem}>Dismiss</button></div>
        ) : null}
        <QuestionDialog hold={hold} />
        <Card title={`Step ${step.n} of 6: ${step.name}`} heading={heading}>
          {step.n === 1 ? <Welcome hold={hold} bench={bench} />
            : step.n === 6 ? <Report hold={hold} bench={bench} />
              : <Measure key={step.n} hold={hold} bench={bench} step={step} />}
        </Card>
      </div>
    </div>
  );
}

export default function Calibrate() {
  const hold = useBench();
  const { bench } = hold;
  const fits = bench?.procedures.includes("next_dual_dimension");
  return (
    <>
      <h1>Calibrate</h1>
      {hold.connection === "lost" ? (
        <Notice kind="warn"><p><strong>The connection to the server is lost.</strong> If the server still runs, so does its job. What you
          enter is sent when the connection is back.</p></Notice>
      ) : null}
      {!bench && !hold.problem ? <Busy text="Asking the machine for its settings" /> : null}
      {!bench && hold.problem ? <><ProblemNotice problem={hold.problem} /><button onClick={hold.retry}>Try again</button></> : null}
      <NowBar hold={hold} />
      {bench ? <Status hold={hold} /> : null}
      {bench && !fits ? (
        <Notice kind="warn"><p><strong>{bench.machine} cannot be calibrated on this page.</strong> It has no touch-probe
          procedures for a block. Start the server with a router: <code>caltwin serve --http PORT --machine gantry_router</code>.</p></Notice>
      ) : null}
      {bench && fits ? <Wizard hold={hold} bench={bench} /> : null}
    </>
  );
}
