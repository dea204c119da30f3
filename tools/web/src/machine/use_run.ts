import { useCallback, useEffect, useRef, useState } from "react";
import { answered, api, problemOf, type Problem, type Schemas } from "../api/client";
import { stopRun, transcriptOf } from "./ask";
import type { RunResult } from "./result";

type Run = Schemas["Run"];

export interface Done { id: string; scenario: string; state: Run["state"]; detail: string; result: RunResult | null; transcript: string }

export interface RunHold {
  done: Done | null;
  running: { id: string; scenario: string } | null;
  isStopping: boolean;
  problem: Problem | null;
  begin: (scenario: string) => Promise<void>;
  stop: () => Promise<void>;
}

// Lives as long as the program is open: leaving for another page keeps it.
let kept: Done | null = null;

const pause = (ms: number) => new Promise((done) => setTimeout(done, ms));

async function wholeOf(run: Run, scenario: string): Promise<Done> {
  const transcript = await transcriptOf(run.id).catch((fault: unknown) => {
    if (run.state === "done") throw fault;
    return "";
  });
  return {
    id: run.id, scenario, state: run.state, detail: run.detail ?? "", transcript,
    result: (run.result ?? null) as RunResult | null,
  };
}

export function useRun(): RunHold {
  const [done, setDone] = useState<Done | null>(kept);
  const [running, setRunning] = useState<RunHold["running"]>(null);
  const [isStopping, setStopping] = useState(false);
  const [problem, setProblem] = useState<Problem | null>(null);
  const isGone = useRef(false);
  useEffect(() => {
    isGone.current = false;
    return () => { isGone.current = true; };
  }, []);
  const begin = useCallback(async (scenario: string) => {
    setProblem(null);
    setDone(null);
    setStopping(false);
    setRunning({ id: "", scenario });
    try {
      let run: Run = await answered(api.POST("/api/runs", { body: { scenario, fidelity: "fast" } }));
      setRunning({ id: run.id, scenario });
      while (run.state === "running") {
        await pause(250);
        if (isGone.current) return;
        run = await answered(api.GET("/api/runs/{id}", { params: { path: { id: run.id } } }));
      }
      kept = await wholeOf(run, scenario);
      setDone(kept);
    } catch (fault) {
      setProblem(problemOf(fault));
    } finally {
      setRunning(null);
    }
  }, []);
  const stop = useCallback(async () => {
    if (!running?.id) return;
    setStopping(true);
    await stopRun(running.id).catch((fault: unknown) => setProblem(problemOf(fault)));
  }, [running]);
  return { done, running, isStopping, problem, begin, stop };
}
