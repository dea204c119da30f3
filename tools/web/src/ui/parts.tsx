import { useEffect, useRef, type ReactNode, type Ref, type RefObject } from "react";
import type { Problem } from "../api/client";

// `heading`: of a card whose heading takes the focus.
export function Card({ title, children, aside, heading }: { title: string; children: ReactNode; aside?: ReactNode; heading?: Ref<HTMLHeadingElement> }) {
  return (
    <section className="card" aria-label={title}>
      <div className="card-head">
        <h2 ref={heading} tabIndex={heading ? -1 : undefined}>{title}</h2>
        {aside}
      </div>
      {children}
    </section>
  );
}

// When `key` changes and the button with the focus is gone or off, the focus goes to `target`;
// also from where it waited meanwhile (`waits`).
export function useFocusAfter(key: string | number | undefined, target: RefObject<HTMLElement | null>, waits = "body") {
  const before = useRef(key);
  useEffect(() => {
    const isFirst = before.current === undefined || before.current === key;
    before.current = key;
    if (isFirst) return;
    // The browser takes the focus from a button that is gone or off after it has drawn.
    const timer = setTimeout(() => {
      const at = document.activeElement;
      if (!at || at === document.body || at.matches(`:disabled, ${waits}`)) target.current?.focus();
    }, 100);
    return () => clearTimeout(timer);
  }, [key, target, waits]);
}

// A number with its unit and how sure it is: "62.1 ± 0.8 µm".
export function Figure({ name, value, sd, unit, digits }: {
  name: string;
  value: number | null | undefined;
  sd?: number | null;
  unit: string;
  digits?: number;
}) {
  return (
    <div className="figure">
      <dt>{name}</dt>
      <dd>{value === null || value === undefined ? "not known" : withSd(value, sd, unit, digits)}</dd>
    </div>
  );
}

// As many decimals as two digits of the sd show, else `digits`.
export function withSd(value: number, sd: number | null | undefined, unit: string, digits = 3): string {
  if (!sd || !Number.isFinite(sd)) return `${value.toFixed(digits)} ${unit}`;
  const places = Math.max(0, Math.min(8, 1 - Math.floor(Math.log10(sd))));
  return `${value.toFixed(places)} ± ${sd.toFixed(places)} ${unit}`;
}

export function Notice({ kind, children }: { kind: "info" | "good" | "warn" | "bad"; children: ReactNode }) {
  return (
    <div className={`notice ${kind}`} role={kind === "bad" ? "alert" : "status"}>
      {children}
    </div>
  );
}

export function ProblemNotice({ problem }: { problem: Problem }) {
  const errors = problem.errors ?? [];
  return (
    <Notice kind="bad">
      <p><strong>{problem.detail}</strong></p>
      {errors.map((fault, i) => (
        <p key={i}>
          {fault.file ? <code>{[fault.file, fault.line, fault.column].filter(Boolean).join(":")} </code> : null}
          {fault.detail !== problem.detail ? fault.detail : null}
          {fault.hint ? <span className="hint"> {fault.hint}</span> : null}
        </p>
      ))}
    </Notice>
  );
}

export function Busy({ text }: { text: string }) {
  return (
    <div className="busy" role="status">
      <span className="spinner" aria-hidden="true" /> {text}
    </div>
  );
}
