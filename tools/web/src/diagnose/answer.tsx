import { useId, useState, type KeyboardEvent } from "react";
import { Card, Notice } from "../ui/parts";
import type { Assumed } from "./ask";
import { Baseline } from "./details";
import { Correction } from "./correction";
import { Findings } from "./findings";
import { GainCard } from "./gain";
import { Drawn } from "./drawn";
import { Pictures } from "./pictures";
import type { Diagnosis } from "./types";
import { headOf, kindOf } from "./verdict";
import { first, nice, size } from "./words";

export function AnswerTabs({ diagnoses, assumed }: { diagnoses: Diagnosis[]; assumed: Assumed }) {
  const [at, setAt] = useState(0);
  const id = useId();
  const one = diagnoses[at];
  if (!one) return null;
  if (diagnoses.length === 1) return <AnswerOf one={one} assumed={assumed} />;
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
        <AnswerOf key={one.id} one={one} assumed={assumed} />
      </div>
    </>
  );
}

function AnswerOf({ one, assumed }: { one: Diagnosis; assumed: Assumed }) {
  return (
    <>
      <VerdictShown one={one} />
      <Meaning one={one} />
      <Reading one={one} />
      <Findings one={one} />
      <Pictures one={one} />
      <Drawn one={one} machine={assumed.machine} />
      <GainCard one={one} />
      <Correction key={assumed.steps} one={one} stepsNow={assumed.steps} />
      <Baseline one={one} />
    </>
  );
}

function VerdictShown({ one }: { one: Diagnosis }) {
  const { head, rest } = headOf(one);
  return (
    <section aria-labelledby={`verdict-${one.id}`} className="verdict">
      <Notice kind={kindOf(one)}>
        <h2 id={`verdict-${one.id}`}>{head}</h2>
        {rest ? <p className="says">{rest}</p> : null}
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

const lists = [["found", "What was found"], ["cannot_tell", "What these measurements cannot tell"], ["to_do", "What to do"]] as const;

// The summary's lists, under the headings that the report gives them.
function Meaning({ one }: { one: Diagnosis }) {
  const shown = lists.filter(([key]) => one.summary[key].length > 0);
  if (shown.length === 0) return null;
  return (
    <Card title="What it means">
      {shown.map(([key, title]) => (
        <div key={key}>
          <h3>{title}</h3>
          <ul className="facts">{one.summary[key].map((says) => <li key={says}>{nice(says)}</li>)}</ul>
        </div>
      ))}
    </Card>
  );
}
