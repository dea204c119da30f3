import { answered, api } from "../api/client";
import type { PosesData, PoseSource, SceneData } from "./data";

// What is shown: a scenario's machine with its hidden errors, a machine without any, or the twin on
// the bench with its own.
export interface Subject {
  of: "scenarios" | "machines" | "bench";
  name: string;
  exaggerate: number;
}

// What was given up is no problem of the server's.
async function unlessAborted<T>(asked: Promise<T>, signal: AbortSignal): Promise<T> {
  return asked.catch((fault: unknown) => {
    throw signal.aborted ? signal.reason : fault;
  });
}

const paramsOf = ({ name, exaggerate }: Subject) => ({ path: { name }, query: { exaggerate } });

export async function sceneOf(subject: Subject, signal: AbortSignal): Promise<SceneData> {
  const params = paramsOf(subject);
  const init = { params, signal };
  if (subject.of === "bench") return unlessAborted(answered(api.GET("/api/bench/scene", { params: { query: params.query }, signal })), signal);
  return unlessAborted(answered(subject.of === "scenarios" ? api.GET("/api/scenarios/{name}/scene", init)
    : api.GET("/api/machines/{name}/scene", init)), signal);
}

export const posesFrom = (subject: Subject): PoseSource => (positions, signal) => posesOf(subject, positions, signal);

export async function posesOf(subject: Subject, positions: number[][], signal: AbortSignal): Promise<PosesData> {
  const params = paramsOf(subject);
  const init = { params, body: { positions }, signal };
  if (subject.of === "bench") return unlessAborted(answered(api.POST("/api/bench/poses", { ...init, params: { query: params.query } })), signal);
  return unlessAborted(answered(subject.of === "scenarios" ? api.POST("/api/scenarios/{name}/poses", init)
    : api.POST("/api/machines/{name}/poses", init)), signal);
}

export const transcriptPath = (id: string) => `/api/runs/${encodeURIComponent(id)}/transcript`;

export async function transcriptOf(id: string): Promise<string> {
  return answered<string>(api.GET("/api/runs/{id}/transcript", { params: { path: { id } }, parseAs: "text" }));
}

export async function stopRun(id: string): Promise<void> {
  await answered(api.POST("/api/runs/{id}/stop", { params: { path: { id } } }));
}

export const picturePath = (machine: string) => `/api/machines/${encodeURIComponent(machine)}/picture`;
