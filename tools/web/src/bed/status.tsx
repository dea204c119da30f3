import { Notice, ProblemNotice } from "../ui/parts";
import type { Problem } from "../api/client";
import { isRaised, type BedStatus } from "./maths";
import type { Bed } from "./use_bed";

export function StatusLine({ bed, status }: { bed: Bed; status: BedStatus }) {
  const holder = bed.doing ? "you, at this page" : status.held_by;
  const state = !status.is_measured ? "not measured yet"
    : isRaised(status) ? "measured, and the screws moved since" : "measured, the screws not moved since";
  return (
    <dl className="figures bed-status">
      <div className="figure"><dt>Printer</dt><dd>{status.machine}</dd></div>
      <div className="figure"><dt>State of the bed</dt><dd>{state}</dd></div>
      <div className="figure"><dt>Who moves it</dt><dd>{holder ? `${holder}${status.doing ? `, ${status.doing}` : ""}` : "nobody now"}</dd></div>
    </dl>
  );
}

export function Troubles({ bed, problem }: { bed: Bed; problem: Problem | null }) {
  return (
    <>
      {bed.connection === "lost" ? (
        <Notice kind="warn">
          <p><strong>The connection to the server is lost.</strong> This page tries again by itself. What it shows may be old.</p>
        </Notice>
      ) : null}
      {problem ? <ProblemNotice problem={problem} /> : null}
    </>
  );
}

// Where a button was pressed, why it did not work.
export function Failure({ failed, doing }: { failed: Bed["failed"]; doing: Bed["doing"] }) {
  if (!failed || failed.doing !== doing) return null;
  const holder = failed.problem.held_by;
  return (
    <>
      <ProblemNotice problem={failed.problem} />
      {holder ? (
        <Notice kind="info">
          <p>At the machine now: <strong>{holder}</strong>. You can look on: touches show here as they come. Try again when they are done.</p>
        </Notice>
      ) : null}
    </>
  );
}
