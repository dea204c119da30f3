// What a machine is drawn from, whoever gives it: the server, or the page of a report.
import type { Schemas } from "../api/problem";

export type SceneData = Schemas["Scene"];
export type PosesData = Schemas["Poses"];
export type Geom = SceneData["geoms"][number];
export type Pose = number[];

// Where the moving bodies stand with the tip at those positions.
export type PoseSource = (positions: number[][], signal: AbortSignal) => Promise<PosesData>;
