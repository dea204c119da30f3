// The emergency stop: sent by any page, and remembered until somebody has gone on.
import { useSyncExternalStore } from "react";
import { answered, api, problemOf, type Problem, type Schemas } from "./client";

export interface Stopped {
  at: string;
  // Whether the server took it; without an answer nothing is known to have stopped.
  isTaken: boolean;
  // Whether M112 went to a real controller.
  isHalted: boolean;
  // Whether something was at work.
  wasAtWork: boolean;
}

const key = "emergency-stop";
let stopped: Stopped | null = JSON.parse(sessionStorage.getItem(key) ?? "null") as Stopped | null;
const listeners = new Set<() => void>();

function set(next: Stopped | null) {
  stopped = next;
  if (next) sessionStorage.setItem(key, JSON.stringify(next));
  else sessionStorage.removeItem(key);
  for (const listener of listeners) listener();
}

const listen = (listener: () => void) => {
  listeners.add(listener);
  return () => { listeners.delete(listener); };
};

export const useStopped = () => useSyncExternalStore(listen, () => stopped);

export const forgetStop = () => set(null);

// The bed of practice is another machine than the bench: both are told.
export async function stopNow(): Promise<void> {
  const at = new Date().toISOString();
  const bed = answered(api.POST("/api/calibration/bed-tilt/abort")).then((one) => one.aborted, () => false);
  const bench = await answered(api.POST("/api/bench/emergency-stop")).catch(() => null);
  const isBedEnded = await bed;
  set({ at, isTaken: bench !== null, isHalted: bench?.sent_m112 === true, wasAtWork: bench?.aborted === true || isBedEnded });
}

// Once somebody has homed the machine and gone on, the stop is over. The server tells whole seconds: as texts a job of
// the second of the stop would be later than it.
export async function forgetIfOver(): Promise<void> {
  const bench: Schemas["Bench"] | null = await answered(api.GET("/api/bench")).catch(() => null);
  if (!bench || bench.is_stopped || !stopped) return;
  const since = (job: Schemas["Job"]) => Date.parse(job.begun_at ?? "") > Date.parse(stopped!.at) && !["home", "reset"].includes(job.procedure);
  if (bench.results.some(since) || (bench.job && since(bench.job))) forgetStop();
}

type Ended = { isDone: true } | { isDone: false; problem: Problem };

const pause = (ms: number) => new Promise((done) => setTimeout(done, ms));

// Runs a procedure of the bench to its end.
export async function runToEnd(procedure: "reset" | "home"): Promise<Ended> {
  try {
    let job: Schemas["Job"] = await answered(api.POST("/api/bench/procedures", { body: { procedure, options: {} } }));
    const { id } = job;
    while (!job.result) {
      await pause(200);
      const bench: Schemas["Bench"] = await answered(api.GET("/api/bench"));
      job = bench.results.find((one) => one.id === id) ?? job;
    }
    if (job.result.ending === "done") return { isDone: true };
    const said = job.result.machine_said ?? `it ended with “${job.result.ending.replaceAll("_", " ")}”`;
    return { isDone: false, problem: { type: "about:blank", title: "Not done", status: 0, detail: `The controller did not do it: ${said}` } };
  } catch (fault) {
    return { isDone: false, problem: problemOf(fault) };
  }
}
