import type { Pose, PosesData, PoseSource } from "./data";

const chunk = 400;

type Chunk = PosesData | "asked" | "failed";

// Poses of the moving bodies at waypoints, asked for in chunks before they are needed.
export class PoseTrack {
  private chunks = new Map<number, Chunk>();
  private control = new AbortController();
  constructor(private source: PoseSource, private points: number[][], private onCame: (fault: unknown) => void) {}

  private ask(index: number) {
    if (index < 0 || index * chunk >= this.points.length || this.chunks.has(index)) return;
    this.chunks.set(index, "asked");
    const { signal } = this.control;
    this.source(this.points.slice(index * chunk, (index + 1) * chunk), signal).then((came) => {
      this.chunks.set(index, came);
      this.onCame(null);
    }, (fault: unknown) => {
      if (signal.aborted) return;
      this.chunks.set(index, "failed");
      this.onCame(fault);
    });
  }

  // Asks for what surrounds a waypoint; whether it is there already.
  prepare(waypoint: number): boolean {
    const index = Math.floor(waypoint / chunk);
    this.ask(index);
    this.ask(Math.floor((waypoint + 1) / chunk));
    if (waypoint % chunk > chunk / 4) this.ask(index + 1);
    return this.at(waypoint) !== undefined;
  }

  // undefined: not there yet; null: out of reach.
  at(waypoint: number): Pose[] | null | undefined {
    const held = this.chunks.get(Math.floor(waypoint / chunk));
    return typeof held === "object" ? held.poses[waypoint % chunk] : undefined;
  }

  bodies(): number[] {
    for (const held of this.chunks.values()) if (typeof held === "object") return held.bodies;
    return [];
  }

  forgetFailed() {
    for (const [index, held] of this.chunks) if (held === "failed") this.chunks.delete(index);
  }

  free() {
    this.control.abort();
  }
}

export function between(from: Pose[], to: Pose[], share: number): Pose[] {
  return from.map((pose, i) => {
    const next = to[i] ?? pose;
    const same = pose.slice(3).reduce((sum, value, k) => sum + value * next[k + 3]!, 0) < 0 ? -1 : 1;
    return pose.map((value, k) => value + ((k < 3 ? next[k]! : same * next[k]!) - value) * share);
  });
}
