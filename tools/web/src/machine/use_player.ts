import { useCallback, useEffect, useMemo, useRef, useState } from "react";
import { problemOf, type Problem } from "../api/problem";
import type { PoseSource, SceneData } from "./data";
import { between, PoseTrack } from "./poses";
import { before, stepAt, type Track } from "./transcript";
import type { World } from "./world";

export interface Player {
  step: number;
  isPlaying: boolean;
  isWaiting: boolean;
  isOutOfReach: boolean;
  speed: number;
  problem: Problem | null;
  setSpeed: (speed: number) => void;
  play: () => void;
  pause: () => void;
  goTo: (step: number) => void;
  again: () => void;
}

interface Frame { isThere: boolean; isOutOfReach: boolean }

// Bodies as they stand at a time of the track; dots of what was touched until then.
class Stage {
  private touches: number[];
  private dotted = 0;
  constructor(private track: Track, private poses: PoseTrack, private world: World) {
    this.touches = track.steps.flatMap((step) => (step.touch === null ? [] : [step.touch]));
    world.clearDots();
  }

  at(time: number): Frame {
    const { times } = this.track;
    const from = before(times.length, (i) => times[i]!, time);
    const to = Math.min(times.length - 1, from + 1);
    this.poses.prepare(from);
    this.leaveDots(from);
    const [start, end] = [this.poses.at(from), this.poses.at(to)];
    if (start === undefined || end === undefined) return { isThere: false, isOutOfReach: false };
    const shown = start && end ? between(start, end, shareOf(times[from]!, times[to]!, time)) : start ?? end;
    if (shown) this.world.move(this.poses.bodies(), shown);
    return { isThere: true, isOutOfReach: start === null };
  }

  private leaveDots(waypoint: number) {
    for (; this.dotted < this.touches.length && this.touches[this.dotted]! <= waypoint; this.dotted++) {
      const at = this.touches[this.dotted]!;
      if (!this.poses.prepare(at)) break;
      this.world.dot(this.poses.bodies(), this.poses.at(at) ?? []);
    }
    this.world.countDots(this.touches.filter((at) => at <= waypoint).length);
  }
}

const shareOf = (from: number, to: number, time: number) =>
  (to > from ? Math.max(0, Math.min(1, (time - from) / (to - from))) : 0);

export const speeds = [1, 2, 5, 10, 20, 50, 100, 200];

// So that a run is seen in about half a minute.
const goodSpeed = (track: Track | null): number => {
  const whole = track?.times.at(-1) ?? 0;
  return speeds.find((speed) => whole / speed <= 40) ?? speeds.at(-1)!;
};

function useStage(track: Track | null, source: PoseSource | null, data: SceneData | null, world: World | null, onCame: (fault: unknown) => void) {
  const stage = useRef<{ stage: Stage; poses: PoseTrack } | null>(null);
  useEffect(() => {
    if (!track || !source || !data?.moves || !world) return;
    const poses = new PoseTrack(source, track.points, onCame);
    stage.current = { stage: new Stage(track, poses, world), poses };
    onCame(null);
    return () => {
      poses.free();
      stage.current = null;
    };
  }, [track, source, data, world, onCame]);
  return stage;
}

function useClock(track: Track | null) {
  const time = useRef(0);
  const [step, setStep] = useState(0);
  const [isPlaying, setPlaying] = useState(false);
  const [speed, setSpeed] = useState(1);
  useEffect(() => {
    time.current = 0;
    setStep(0);
    setPlaying(false);
    setSpeed(goodSpeed(track));
  }, [track]);
  return { time, step, setStep, isPlaying, setPlaying, speed, setSpeed };
}

// Where poses are still on their way, time stands.
function useTicking(track: Track | null, clock: ReturnType<typeof useClock>, showNow: { current: () => boolean }) {
  const { time, setStep, isPlaying, setPlaying, speed } = clock;
  useEffect(() => {
    if (!isPlaying || !track) return;
    const end = track.times.at(-1) ?? 0;
    let last = performance.now();
    let frame = 0;
    const tick = (now: number) => {
      const passed = Math.min(0.25, (now - last) / 1000);
      last = now;
      if (showNow.current()) time.current = Math.min(end, time.current + passed * speed);
      setStep(stepAt(track, time.current));
      if (time.current >= end) setPlaying(false);
      else frame = requestAnimationFrame(tick);
    };
    frame = requestAnimationFrame(tick);
    return () => cancelAnimationFrame(frame);
  }, [isPlaying, track, speed, time, setStep, setPlaying, showNow]);
}

export function usePlayer(track: Track | null, source: PoseSource | null, data: SceneData | null, world: World | null): Player {
  const clock = useClock(track);
  const { time, setStep, isPlaying, setPlaying, speed } = clock;
  const [isWaiting, setWaiting] = useState(false);
  const [isOutOfReach, setOutOfReach] = useState(false);
  const [problem, setProblem] = useState<Problem | null>(null);
  const showNow = useRef<() => boolean>(() => true);
  const onCame = useCallback((fault: unknown) => {
    setProblem(fault ? problemOf(fault) : null);
    if (!fault) showNow.current();
  }, []);
  const stage = useStage(track, source, data, world, onCame);
  showNow.current = () => {
    if (!stage.current) return true;
    const frame = stage.current.stage.at(time.current);
    setWaiting(!frame.isThere);
    setOutOfReach(frame.isOutOfReach);
    return frame.isThere;
  };
  const end = track?.times.at(-1) ?? 0;
  useTicking(track, clock, showNow);
  return useMemo(() => ({
    step: clock.step, isPlaying, isWaiting, isOutOfReach, speed, problem, setSpeed: clock.setSpeed,
    play: () => {
      if (time.current >= end) time.current = 0;
      setPlaying(true);
    },
    pause: () => setPlaying(false),
    goTo: (to: number) => {
      if (!track) return;
      const step = Math.max(0, Math.min(track.steps.length - 1, to));
      setPlaying(false);
      time.current = track.steps[step]?.end ?? 0;
      setStep(step);
      showNow.current();
    },
    again: () => {
      stage.current?.poses.forgetFailed();
      showNow.current();
    },
  }), [clock.step, clock.setSpeed, isPlaying, isWaiting, isOutOfReach, speed, problem, track, end, time, setStep, setPlaying, stage]);
}
