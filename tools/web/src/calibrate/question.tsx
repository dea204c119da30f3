import { useEffect, useRef, useState } from "react";
import type { Question } from "./model";
import { plain, unitOf, valueOf } from "./words";
import type { BenchHold } from "./use_bench";

const titles: Record<Question["kind"], string> = {
  confirm: "Apply this change?",
  turn_block: "Turn the block",
  fit_stylus: "Fit the stylus",
  other: "Your answer, please",
  reading: "Read the gauge",
  zero: "Zero the gauge",
};

const yesTexts: Record<Question["kind"], string> = {
  confirm: "Apply", turn_block: "It is turned, go on", fit_stylus: "It is fitted, go on",
  other: "Yes, go on", reading: "Enter the reading", zero: "It is zeroed, go on",
};

interface Proposal { name: string; from: number; to: number; why: string }

export function proposalOf(text: string): Proposal | null {
  const found = /^Set (\S+) from (-?[\d.]+) to (-?[\d.]+)\? ?(.*)$/s.exec(text);
  if (!found) return null;
  return { name: found[1]!, from: Number(found[2]), to: Number(found[3]), why: found[4] ?? "" };
}

function ProposalTable({ proposal }: { proposal: Proposal }) {
  const { name, from, to, why } = proposal;
  const percent = name.startsWith("steps_per_mm") && from ? ` (${to >= from ? "+" : "−"}${(Math.abs(to / from - 1) * 100).toFixed(3)} %)` : "";
  const places = name.startsWith("steps_per_mm") ? 3 : 4;
  return (
    <>
      <dl className="figures">
        <div className="figure"><dt>Setting</dt><dd>{plain(name)}</dd></div>
        <div className="figure"><dt>Now</dt><dd>{valueOf(name, from)}</dd></div>
        <div className="figure"><dt>Proposed</dt><dd><strong>{valueOf(name, to)}</strong></dd></div>
        <div className="figure"><dt>Change</dt><dd>{`${to >= from ? "+" : "−"}${Math.abs(to - from).toFixed(places)} ${unitOf(name)}${percent}`}</dd></div>
      </dl>
      <p>{plain(why)} The value from before is kept: you can restore it at any time.</p>
    </>
  );
}

function ReadingForm({ question, hold, busy, send }: {
  question: Question; hold: BenchHold; busy: boolean; send: (yes: boolean, value?: number) => void;
}) {
  const [text, setText] = useState("");
  const value = Number(text.replace(",", "."));
  const isNumber = text.trim() !== "" && Number.isFinite(value);
  return (
    <form className="row" onSubmit={(event) => { event.preventDefault(); if (isNumber) send(true, value); }}>
      {question.hint_mm !== undefined && hold.bench?.is_twin ? (
        <button type="button" disabled={busy} onClick={() => send(true, question.hint_mm)}>
          Use what the simulated gauge reads: {question.hint_mm.toFixed(4)} mm
        </button>
      ) : null}
      <label>Reading in mm
        <input inputMode="decimal" value={text} onChange={(event) => setText(event.target.value)} size={10} />
      </label>
      <button className="quiet" disabled={busy || !isNumber}>{yesTexts.reading}</button>
      <button type="button" className="quiet" disabled={busy} onClick={() => send(false)}>I cannot read it</button>
    </form>
  );
}

const noText = (kind: Question["kind"]) => (kind === "confirm" ? "No, keep the value as it is" : "No, stop here");

// Not modal on purpose: Abort in the status panel must stay within reach.
export function QuestionDialog({ hold }: { hold: BenchHold }) {
  const question = hold.bench?.state === "asking" ? hold.bench.job?.question : null;
  const box = useRef<HTMLElement>(null);
  const [answered, setAnswered] = useState(0);
  const id = question?.id ?? 0;
  useEffect(() => {
    if (id) box.current?.focus();
  }, [id]);
  if (!question) return null;
  const busy = answered === id;
  const send = (yes: boolean, value?: number) => {
    setAnswered(id);
    void hold.answer(id, yes, value).then((taken) => { if (!taken) setAnswered(0); });
  };
  const proposal = question.kind === "confirm" ? proposalOf(question.text) : null;
  return (
    <section className="card cal-question" role="dialog" aria-labelledby="cal-question-title"
             aria-describedby="cal-question-text" tabIndex={-1} ref={box}>
      <h2 id="cal-question-title">{titles[question.kind] ?? titles.other}</h2>
      <div id="cal-question-text">
        {proposal ? <ProposalTable proposal={proposal} /> : <p>{plain(question.text)}</p>}
        {question.kind === "reading" ? (
          <p className="hint">The machine stands still now. Only differences between readings count, so the gauge may have any zero.</p>
        ) : null}
      </div>
      {question.kind === "reading" ? <ReadingForm key={id} question={question} hold={hold} busy={busy} send={send} /> : (
        <div className="row">
          <button disabled={busy} onClick={() => send(true)}>{yesTexts[question.kind] ?? yesTexts.other}</button>
          <button className="quiet" disabled={busy} onClick={() => send(false)}>{noText(question.kind)}</button>
        </div>
      )}
      {hold.bench?.is_twin && question.kind !== "confirm" ? (
        <p>
          <label className="inline">
            <input type="checkbox" checked={hold.entries.twinHands}
                   onChange={(event) => hold.keep({ twinHands: event.target.checked })} />
            Let the simulated machine turn the block and read gauges by itself from now on. Changes still ask you.
          </label>
        </p>
      ) : null}
    </section>
  );
}
