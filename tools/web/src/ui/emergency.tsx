import "./emergency.css";
import { useEffect, useRef, useState } from "react";
import { forgetIfOver, forgetStop, runToEnd, stopNow, useStopped, type Stopped } from "../api/emergency";
import type { Problem } from "../api/client";
import { Busy, ProblemNotice } from "./parts";

// Asks nothing and is never disabled: pressed again it is sent again.
export function StopButton({ onPressed }: { onPressed?: () => void }) {
  return (
    <button type="button" className="stop-button" onClick={() => { void stopNow(); onPressed?.(); }}>Emergency stop</button>
  );
}

// Fixed in a corner of every page that moves a machine.
export function StopCorner() {
  return <aside className="stop-corner" aria-label="Emergency stop"><StopButton /></aside>;
}

const clock = (at: string) => new Date(at).toLocaleTimeString();

function titleOf(stopped: Stopped): string {
  if (!stopped.isTaken) return "The server did not take the emergency stop";
  return stopped.wasAtWork || stopped.isHalted ? "Emergency stop" : "Emergency stop: nothing was at work";
}

function What({ stopped }: { stopped: Stopped }) {
  if (!stopped.isTaken) {
    return <p><strong>The machine may still move. Press the emergency stop at the machine itself.</strong> The server did not answer at {clock(stopped.at)}.</p>;
  }
  return (
    <>
      <p>
        {stopped.isHalted ? `At ${clock(stopped.at)} the server sent M112 to the controller. It halts its motors at once and then takes no command until it is reset.`
          : `At ${clock(stopped.at)} the simulated machine was told to stop. It stands still after its present line of G-code.`}
        {stopped.wasAtWork ? " The job at work was ended. Nothing more is sent until the machine has been homed." : ""}
      </p>
      {stopped.isHalted ? <p><strong>Look at the machine: this page cannot see whether it stands still.</strong> If it moves, press the emergency stop at the machine itself.</p> : null}
    </>
  );
}

type Doing = "reset" | "home" | null;

function GoOn({ stopped }: { stopped: Stopped }) {
  const [doing, setDoing] = useState<Doing>(null);
  const [problem, setProblem] = useState<Problem | null>(null);
  const [isReset, setReset] = useState(!stopped.isHalted);
  const [isHomed, setHomed] = useState(false);
  const status = useRef<HTMLParagraphElement>(null);
  const go = async (what: "reset" | "home") => {
    setDoing(what);
    setProblem(null);
    const ended = await runToEnd(what);
    setDoing(null);
    if (!ended.isDone) setProblem(ended.problem);
    else if (what === "reset") setReset(true);
    else setHomed(true);
    status.current?.focus();
  };
  const said = isHomed ? "The machine is homed. You can go on: repeat the step that was stopped."
    : stopped.isHalted && isReset ? "The controller is reset. Home the machine next." : "";
  return (
    <>
      <h3>How to go on</h3>
      <ol>
        <li>Remove what made you stop. Keep hands out of the machine.</li>
        {stopped.isHalted ? <li>Reset the controller. If it does not answer, press its reset button.</li> : null}
        <li>Home the machine: after a stop its place is not certain. A bed on three screws is homed by the next measurement.</li>
      </ol>
      <div className="row">
        {stopped.isHalted ? <button type="button" disabled={doing !== null} onClick={() => void go("reset")}>Reset the controller</button> : null}
        <button type="button" disabled={doing !== null || !isReset} onClick={() => void go("home")}>Home after the stop</button>
        <button type="button" className="quiet" onClick={forgetStop}>Close this note</button>
      </div>
      {doing ? <Busy text={doing === "reset" ? "Resetting the controller" : "Homing"} /> : null}
      {problem ? <ProblemNotice problem={problem} /> : null}
      <p ref={status} role="status" tabIndex={-1} className="stop-said">{said}</p>
    </>
  );
}

// What the stop did, in words, and how to go on; its heading takes the focus.
export function StopNote() {
  const stopped = useStopped();
  const heading = useRef<HTMLHeadingElement>(null);
  const at = stopped?.at;
  useEffect(() => { if (at) heading.current?.focus(); }, [at]);
  useEffect(() => {
    if (!at) return;
    const timer = setInterval(() => { void forgetIfOver(); }, 2000);
    return () => { clearInterval(timer); };
  }, [at]);
  if (!stopped) return null;
  return (
    <section className="card stop-note" aria-labelledby="stop-title">
      <div role="alert">
        <h2 id="stop-title" ref={heading} tabIndex={-1}>{titleOf(stopped)}</h2>
        <What stopped={stopped} />
      </div>
      {stopped.isTaken ? <GoOn key={at} stopped={stopped} />
        : <div className="row"><button type="button" className="quiet" onClick={forgetStop}>Close this note</button></div>}
    </section>
  );
}
