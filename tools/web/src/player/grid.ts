// Poses without a server: held at the nodes of a grid, as renders/pose_grid writes it.
import type { Pose, PoseSource } from "../machine/data";
import { before } from "../machine/transcript";

export interface Grid {
  nodes_mm: number[][];
  bodies: number[];
  // By node, z fastest, then y; null: out of reach.
  poses: (Pose[] | null)[];
}

// The node below a place, and how far towards the next it is.
function cellOf(nodes: number[], at: number): [number, number] {
  const low = before(nodes.length - 1, (i) => nodes[i]!, at);
  return [low, (at - nodes[low]!) / (nodes[low + 1]! - nodes[low]!)];
}

const isOpposed = (one: Pose, other: Pose) => {
  let product = 0;
  for (let k = 3; k < 7; k++) product += one[k]! * other[k]!;
  return product < 0;
};

// Trilinear, quaternions turned into one sense (place() makes them unit ones); beyond the last
// nodes straight on.
export function posesAt(grid: Grid, tip: number[]): Pose[] | null {
  const cells = grid.nodes_mm.map((nodes, axis) => cellOf(nodes, tip[axis] ?? 0));
  const sum = grid.bodies.map((): Pose => [0, 0, 0, 0, 0, 0, 0]);
  let like: Pose[] | null = null;
  for (let corner = 0; corner < 8; corner++) {
    const ends = cells.map((_, axis) => (corner >> axis) & 1);
    const share = cells.reduce((product, [, towards], axis) => product * (ends[axis] ? towards : 1 - towards), 1);
    if (share === 0) continue;
    const index = cells.reduce((sofar, [low], axis) => sofar * grid.nodes_mm[axis]!.length + low + ends[axis]!, 0);
    const node = grid.poses[index];
    if (!node) return null;
    like ??= node;
    for (const [body, pose] of node.entries()) {
      const turned = isOpposed(pose, like[body]!) ? -share : share;
      for (let k = 0; k < 7; k++) sum[body]![k]! += (k < 3 ? share : turned) * pose[k]!;
    }
  }
  return sum;
}

export const posesIn = (grid: Grid): PoseSource => async (positions) =>
  ({ bodies: grid.bodies, poses: positions.map((tip) => posesAt(grid, tip)) });
