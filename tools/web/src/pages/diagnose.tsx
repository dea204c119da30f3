import "../diagnose/diagnose.css";
import { useEffect, useRef, useState } from "react";
import type { Problem } from "../api/client";
import { Busy, Card, ProblemNotice } from "../ui/parts";
import { AnswerTabs } from "../diagnose/answer";
import { ask, nothingAssumed, withHeader, type Answer, type Assumed, type Refused } from "../diagnose/ask";
import { ChangeAssumed } from "../diagnose/assumed";
import { Columns, columnsFound } from "../diagnose/columns";
import { Drop } from "../diagnose/drop";
import { Recent } from "../diagnose/recent";
import { hasOwnMachine } from "../diagnose/types";
import { headOf } from "../diagnose/verdict";

interface Asked { files: File[]; assumed: Assumed }

// Answers live as long as the program is open: leaving for another page keeps them.
let kept: Answer[] = [];

function useAnswers() {
  const [answers, setAnswers] = useState<Answer[]>(kept);
  const [shown, setShown] = useState<Answer | null>(kept[0] ?? null);
  const [asked, setAsked] = useState<Asked | null>(null);
  const [refused, setRefused] = useState<Refused | null>(null);
  const running = useRef<AbortController | null>(null);
  useEffect(() => { kept = answers; }, [answers]);
  useEffect(() => () => running.current?.abort(), []);
  const put = async (next: Asked) => {
    running.current?.abort();
    const control = new AbortController();
    running.current = control;
    setAsked(next);
    setRefused(null);
    const answer = await ask(next.files, next.assumed, control.signal);
    if (control.signal.aborted) return;
    const whole: Answer = { key: Date.now(), at: new Date(), ...next, ...answer };
    setAsked(null);
    if (answer.diagnoses.length === 0 && shown && shown.files === next.files && shown.diagnoses.length > 0) {
      setRefused({ assumed: next.assumed, problems: answer.problems });
      return;
    }
    setShown(whole);
    if (answer.diagnoses.length > 0) setAnswers((all) => [whole, ...all].slice(0, 20));
  };
  const stop = () => { running.current?.abort(); setAsked(null); };
  const open = (answer: Answer) => { stop(); setRefused(null); setShown(answer); };
  return { answers, shown, open, asked, refused, put, stop };
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

const isUnread = (problem: Problem) => /^which column/i.test(problem.detail);

// A table whose columns nobody knows is asked about, also where other files were answered.
function Failed({ answer, onAgain, onMap }: { answer: Answer; onAgain: () => void; onMap: (map: string, file: string) => void }) {
  const again = answer.problems.some((problem) => problem.status === 0 || problem.status >= 500);
  const tables = answer.problems.filter(isUnread).map((problem) => (
    { file: problem.errors?.[0]?.file ?? answer.files[0]?.name ?? "", found: columnsFound(problem.detail) }));
  return (
    <>
      {answer.problems.map((problem, i) => <ProblemNotice key={i} problem={problem} />)}
      {again
        ? <p><button type="button" className="quiet" onClick={onAgain}>Try again</button></p>
        : null}
      {tables.filter(({ found }) => found.length > 1).map(({ file, found }) => (
        <Columns key={file} file={answer.files.length > 1 ? file : ""} found={found} onMap={(map) => onMap(map, file)} />
      ))}
      {answer.diagnoses.length > 0 ? <p className="hint">The other files are answered below.</p> : null}
    </>
  );
}

// The file that the machine was read from: the data's own, or one that came along.
function machineFileOf(answer: Answer): string | null {
  const own = answer.diagnoses.find(hasOwnMachine);
  if (own) return own.import.file;
  const along = answer.files.find((file) => /\.yaml$/.test(file.name) && withHeader(answer.files, file.name).length === 1);
  const isUnnamed = answer.diagnoses.some((one) => (one.remarks ?? []).some((remark) => remark.startsWith("no machine is named")));
  return along && answer.diagnoses.length > 0 && !isUnnamed ? along.name : null;
}

function spoken(answer: Answer): string {
  const verdicts = answer.diagnoses.map((one) => `${one.import.file}: ${headOf(one).head}`);
  return verdicts.length > 0 ? `Answered. ${verdicts.join(" ")}` : "Not answered.";
}

export default function Diagnose() {
  const { answers, shown, open, asked, refused, put, stop } = useAnswers();
  const result = useRef<HTMLDivElement>(null);
  // By itself: the columns of one table are not those of another.
  const asColumns = (of: Answer) => (columns: string, file: string) => put({ files: withHeader(of.files, file), assumed: { ...of.assumed, columns } });
  const assumed = asked?.assumed ?? shown?.assumed ?? nothingAssumed;
  useEffect(() => {
    if (shown) result.current?.scrollIntoView({ block: "start" });
  }, [shown]);
  return (
    <div className="diagnose">
      <h1>What is wrong with my machine?</h1>
      <Drop onFiles={(files) => put({ files, assumed: { ...nothingAssumed, machine: assumed.machine } })} />
      <p className="unseen" aria-live="polite">{asked ? "Answering." : refused ? "Refused. The answer before stays." : shown ? spoken(shown) : ""}</p>
      <div ref={result} className="result" aria-busy={asked !== null}>
        {asked ? <Waiting asked={asked} onStop={stop} /> : null}
        {shown ? (
          <div key={shown.key} className={asked ? "old" : undefined}>
            {shown.problems.length > 0 ? <Failed answer={shown} onAgain={() => put(shown)} onMap={asColumns(shown)} /> : null}
            {shown.diagnoses.length > 0 ? <AnswerTabs diagnoses={shown.diagnoses} assumed={shown.assumed} /> : null}
          </div>
        ) : null}
        {!asked && !shown ? <Empty /> : null}
      </div>
      {shown ? <ChangeAssumed assumed={assumed} refused={refused} machineFile={machineFileOf(shown)} onChange={(next) => put({ files: shown.files, assumed: next })} /> : null}
      <Recent answers={answers} shown={shown} onOpen={open} />
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
