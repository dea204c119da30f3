import { operatorName, problemOf } from "../api/client";

export type Pose = number[];

export interface Geom {
  body: number;
  type: string;
  size_mm: number[];
  pose: Pose;
  rgba: number[];
  mesh: number | null;
}

export interface SceneData {
  machine: string;
  moves: boolean;
  travel_mm: number[][];
  bodies: string[];
  poses: Pose[];
  geoms: Geom[];
  meshes: { vertices_mm: number[]; faces: number[] }[];
}

export interface PosesData {
  bodies: number[];
  poses: (Pose[] | null)[];
}

// What is shown: a scenario's machine with its hidden errors, or a machine without any.
export interface Subject {
  of: "scenarios" | "machines";
  name: string;
  exaggerate: number;
}

async function fetched(path: string, init: RequestInit): Promise<Response> {
  const response = await fetch(path, { ...init, headers: { ...init.headers, "X-Operator": operatorName() } })
    .catch((fault: unknown) => {
      throw init.signal?.aborted ? fault : problemOf(fault);
    });
  if (response.ok) return response;
  throw problemOf(await response.json().catch(() => null));
}

const routeOf = (subject: Subject, leaf: string) =>
  `/api/${subject.of}/${encodeURIComponent(subject.name)}/${leaf}${subject.exaggerate > 1 ? `?exaggerate=${subject.exaggerate}` : ""}`;

export async function sceneOf(subject: Subject, signal: AbortSignal): Promise<SceneData> {
  return await (await fetched(routeOf(subject, "scene"), { signal })).json() as SceneData;
}

export async function posesOf(subject: Subject, positions: number[][], signal: AbortSignal): Promise<PosesData> {
  const init = { method: "POST", body: JSON.stringify({ positions }), headers: { "Content-Type": "application/json" }, signal };
  return await (await fetched(routeOf(subject, "poses"), init)).json() as PosesData;
}

export const transcriptPath = (id: string) => `/api/runs/${encodeURIComponent(id)}/transcript`;

export async function transcriptOf(id: string): Promise<string> {
  return await (await fetched(transcriptPath(id), {})).text();
}

export async function stopRun(id: string): Promise<void> {
  await fetched(`/api/runs/${encodeURIComponent(id)}/stop`, { method: "POST" });
}

export const picturePath = (machine: string) => `/api/machines/${encodeURIComponent(machine)}/picture`;
