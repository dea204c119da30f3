import { answered, api } from "../api/client";
import type { PosesData, PoseSource, SceneData } from "./data";

// What is shown: a scenario's machine with its hidden errors, or a machine without any.
export interface Subject {
  of: "scenarios" | "machines";
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
  const init = { params: paramsOf(subject), signal };
  return unlessAborted(answered(subject.of === "scenarios" ? api.GET("/api/scenarios/{name}/scene", init)
    : api.GET("/api/machines/{name}/scene", init)), signal);
}

export const posesFrom = (subject: Subject): PoseSource => (positions, signal) => posesOf(subject, positions, signal);

export async function posesOf(subject: Subject, positions: number[][], signal: AbortSignal): Promise<PosesData> {
  const init = { params: paramsOf(subject), body: { positions }, signal };
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
