import { useId, useState, type KeyboardEvent } from "react";
import { Card, Notice } from "../ui/parts";
import { Baseline, NextSteps } from "./details";
import { Correction } from "./correction";
import { Findings } from "./findings";
import { GainCard } from "./gain";
import { Drawn } from "./drawn";
import { Pictures } from "./pictures";
import type { Diagnosis } from "./types";
import { verdictOf } from "./verdict";
import { first, nice, size } from "./words";

export function AnswerTabs({ diagnoses, machine }: { diagnoses: Diagnosis[]; machine: string }) {
  const [at, setAt] = useState(0);
  const id = useId();
  const one = diagnoses[at];
  if (!one) return null;
  if (diagnoses.length === 1) return <AnswerOf one={one} machine={machine} />;
  const move = (event: KeyboardEvent) => {
    const step = event.key === "ArrowRight" ? 1 : event.key === "ArrowLeft" ? -1 : 0;
    if (step === 0) return;
    const next = (at + step + diagnoses.length) % diagnoses.length;
    setAt(next);
    document.getElementById(`${id}-tab-${next}`)?.focus();
  };
  return (
    <>
      <div role="tablist" aria-label="Answers, one a file" className="tabs" onKeyDown={move}>
        {diagnoses.map((each, i) => (
          <button key={each.id} type="button" role="tab" id={`${id}-tab-${i}`} aria-selected={i === at}
                  aria-controls={`${id}-panel`} tabIndex={i === at ? 0 : -1} onClick={() => setAt(i)}>
            {each.import.file}
          </button>
        ))}
      </div>
      <div role="tabpanel" id={`${id}-panel`} aria-labelledby={`${id}-tab-${at}`} tabIndex={-1}>
        <AnswerOf key={one.id} one={one} machine={machine} />
      </div>
    </>
  );
}

function AnswerOf({ one, machine }: { one: Diagnosis; machine: string }) {
  return (
    <>
      <VerdictShown one={one} />
      <Reading one={one} />
      <Findings one={one} />
      <Facts one={one} />
      <Drawn one={one} machine={machine} />
      <GainCard one={one} />
      <NextSteps one={one} />
      <Correction one={one} />
      <Baseline one={one} />
      <Pictures one={one} />
    </>
  );
}

function VerdictShown({ one }: { one: Diagnosis }) {
  const { kind, title, says, more } = verdictOf(one);
  return (
    <section aria-labelledby={`verdict-${one.id}`} className="verdict">
      <Notice kind={kind}>
        <h2 id={`verdict-${one.id}`}>{title}</h2>
        <p className="says">{nice(says)}</p>
        {more.map((line) => <p key={line}>{nice(line)}</p>)}
      </Notice>
      <p className="links">
        <a href={`/api/diagnoses/${one.id}/report`} target="_blank" rel="noreferrer">Whole report (new tab)</a>
        <a href={`/api/diagnoses/${one.id}/rows`} download={`${one.import.file}.rows.csv`}>Rows as they were read (CSV)</a>
      </p>
    </section>
  );
}

function Reading({ one }: { one: Diagnosis }) {
  const notes = [...new Set([...one.import.notes, ...(one.remarks ?? [])])];
  const read = notes.filter((note) => note.startsWith("read as "));
  const assumed = notes.filter((note) => note.startsWith("assumed"));
  const rest = notes.filter((note) => !read.includes(note) && !assumed.includes(note));
  const out = one.outlier_rows ?? [];
  const flagged = (one.show?.flagged_rows ?? []).filter((row) => row.left_out);
  return (
    <Card title="What was read">
      <p><strong>{one.import.file}</strong>{read.length > 0 ? `: ${nice(read.map((note) => note.replace(/^read as /, "")).join("; "))}.` : ""}</p>
      {out.length > 0 ? (
        <Notice kind="warn">
          <p><strong>Left out as bad readings:</strong> row{out.length > 1 ? "s" : ""} {out.join(", ")}.
            {flagged.map((row) => ` Row ${row.row} is ${size(row.left_um)} off.`).join("")}
            {" "}Measure {out.length > 1 ? "them" : "it"} again if you can.</p>
        </Notice>
      ) : null}
      {assumed.length > 0 ? (
        <>
          <h3>Assumed, please check</h3>
          <ul>{assumed.map((note) => <li key={note}>{first(nice(note.replace(/^assumed: /, "")))}.</li>)}</ul>
          <p><a href="#assumed">Change what was assumed</a></p>
        </>
      ) : null}
      {rest.length > 0 ? (
        <details><summary>Further remarks ({rest.length})</summary>
          <ul>{rest.map((note) => <li key={note}>{first(nice(note))}.</li>)}</ul>
        </details>
      ) : null}
    </Card>
  );
}

// What the verdict has not said already.
function Facts({ one }: { one: Diagnosis }) {
  const { says, more } = verdictOf(one);
  const told = [says, ...more].join(" ");
  const facts = (one.facts ?? []).filter((fact) => !told.includes(fact.says))
    .sort((a, b) => Number(b.is_answer) - Number(a.is_answer));
  if (facts.length === 0) return null;
  return (
    <Card title="What the numbers also say">
      <ul className="facts">
        {facts.map((fact) => <li key={fact.says}>{fact.is_answer ? <strong>{nice(fact.says)}.</strong> : `${nice(fact.says)}.`}</li>)}
      </ul>
    </Card>
  );
}
