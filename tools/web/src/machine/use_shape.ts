import { useEffect, useState } from "react";
import { problemOf, type Problem } from "../api/client";
import { sceneOf, type Subject } from "./ask";
import type { SceneData } from "./data";

// The drawing, and what it is of: while another is asked for or refused, the one before stays.
export interface Shape {
  data: SceneData | null;
  of: Subject | null;
  isLoading: boolean;
  problem: Problem | null;
  again: () => void;
}

const isSame = (one: Subject | null, other: Subject | null) => one?.of === other?.of && one?.name === other?.name;

export function useShape(subject: Subject | null): Shape {
  const [held, setHeld] = useState<{ data: SceneData; of: Subject } | null>(null);
  const [isLoading, setLoading] = useState(false);
  const [problem, setProblem] = useState<Problem | null>(null);
  const [tries, setTries] = useState(0);
  useEffect(() => {
    if (!subject) return;
    const control = new AbortController();
    setLoading(true);
    setProblem(null);
    setHeld((was) => (was && isSame(was.of, subject) ? was : null));
    sceneOf(subject, control.signal).then((data) => setHeld({ data, of: subject }), (fault: unknown) => {
      if (!control.signal.aborted) setProblem(problemOf(fault));
    }).finally(() => { if (!control.signal.aborted) setLoading(false); });
    return () => control.abort();
  }, [subject, tries]);
  const own = held && isSame(held.of, subject) ? held : null;
  return { data: own?.data ?? null, of: own?.of ?? null, isLoading, problem, again: () => setTries((was) => was + 1) };
}
