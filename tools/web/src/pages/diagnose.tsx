import "../diagnose/diagnose.css";
import { useEffect, useRef, useState } from "react";
import { Busy, Card, ProblemNotice } from "../ui/parts";
import { AnswerTabs } from "../diagnose/answer";
import { ask, nothingAssumed, type Answer, type Assumed } from "../diagnose/ask";
import { ChangeAssumed } from "../diagnose/assumed";
import { Drop } from "../diagnose/drop";
import { Recent } from "../diagnose/recent";

interface Asked { files: File[]; assumed: Assumed }

// Answers live as long as the program is open: leaving for another page keeps them.
let kept: Answer[] = [];

function useAnswers() {
  const [answers, setAnswers] = useState<Answer[]>(kept);
  const [shown, setShown] = useState<Answer | null>(kept[0] ?? null);
  const [asked, setAsked] = useState<Asked | null>(null);
  const running = useRef<AbortController | null>(null);
  useEffect(() => { kept = answers; }, [answers]);
  useEffect(() => () => running.current?.abort(), []);
  const put = async (next: Asked) => {
    running.current?.abort();
    const control = new AbortController();
    running.current = control;
    setAsked(next);
    const answer = await ask(next.files, next.assumed, control.signal);
    if (control.signal.aborted) return;
    const whole: Answer = { key: Date.now(), at: new Date(), ...next, ...answer };
    setAsked(null);
    setShown(whole);
    if (answer.diagnoses.length > 0) setAnswers((all) => [whole, ...all].slice(0, 20));
  };
  const stop = () => { running.current?.abort(); setAsked(null); };
  return { answers, shown, setShown, asked, put, stop };
}

function Waiting({ asked, onStop }: { asked: Asked; onStop: () => void }) {
  const names = asked.files.map((file) => file.name).join(", ");
  return (
    <div className="row waiting">
      <Busy text={`Reading and answering: ${names}`} />
      <button type="button" className="quiet" onClick={onStop}>Stop</button>
    </div>
  );
}

function Failed({ answer, onAgain }: { answer: Answer; onAgain: () => void }) {
  return (
    <>
      {answer.problems.map((problem, i) => <ProblemNotice key={i} problem={problem} />)}
      {answer.diagnoses.length === 0
        ? <p><button type="button" className="quiet" onClick={onAgain}>Try again</button></p>
        : <p className="hint">The other files are answered below.</p>}
    </>
  );
}

export default function Diagnose() {
  const { answers, shown, setShown, asked, put, stop } = useAnswers();
  const result = useRef<HTMLDivElement>(null);
  const assumed = asked?.assumed ?? shown?.assumed ?? nothingAssumed;
  useEffect(() => {
    if (shown) result.current?.scrollIntoView({ block: "start" });
  }, [shown]);
  return (
    <div className="diagnose">
      <h1>What is wrong with my machine?</h1>
      <Drop busy={asked !== null} onFiles={(files) => put({ files, assumed })} />
      <div ref={result} className="result" aria-busy={asked !== null}>
        {asked ? <Waiting asked={asked} onStop={stop} /> : null}
        {!asked && shown && shown.problems.length > 0
          ? <Failed answer={shown} onAgain={() => put(shown)} /> : null}
        {!asked && shown && shown.diagnoses.length > 0 ? <AnswerTabs key={shown.key} diagnoses={shown.diagnoses} /> : null}
        {!asked && !shown ? <Empty /> : null}
      </div>
      {shown ? <ChangeAssumed assumed={assumed} busy={asked !== null} onChange={(next) => put({ files: shown.files, assumed: next })} /> : null}
      <Recent answers={answers} shown={shown} onOpen={setShown} />
    </div>
  );
}

function Empty() {
  return (
    <Card title="What you get">
      <p>One sentence that says what is wrong, or that nothing is. Then how sure that is, what else it could be,
        what to measure next, and the settings to paste into the controller.</p>
    </Card>
  );
}
