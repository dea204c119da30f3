import type { ReactNode } from "react";
import type { Problem } from "../api/client";

export function Card({ title, children, aside }: { title: string; children: ReactNode; aside?: ReactNode }) {
  return (
    <section className="card" aria-label={title}>
      <div className="card-head">
        <h2>{title}</h2>
        {aside}
      </div>
      {children}
    </section>
  );
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
