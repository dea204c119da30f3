import { useCallback, useEffect, useRef, useState } from "react";
import { answered, api, problemOf, type Problem, type Schemas } from "../api/client";
import { useEvents, useNews, type Connection } from "../api/events";
import { posesOf, type Subject } from "./ask";
import type { Pose, SceneData } from "./data";
import { between } from "./poses";
import type { World } from "./world";

export type Bench = Schemas["Bench"];

export interface LiveReading { campaign: string; feature: string; at: number[]; value: number }

export interface LiveHold { bench: Bench | null; readings: LiveReading[]; sent: string[]; connection: Connection; problem: Problem | null; reload: () => void }

type Came = Schemas["Reading"];

const axes = ["x", "y", "z"] as const;

const readingOf = (came: Came): LiveReading => {
  const at = came.at_mm as Partial<Record<string, number>>;
  return { campaign: came.campaign, feature: came.feature, at: axes.map((axis) => at[axis] ?? 0), value: came.value_mm };
};

export function useBenchLive(): LiveHold {
  const [bench, setBench] = useState<Bench | null>(null);
  const [readings, setReadings] = useState<LiveReading[]>([]);
  const [sent, setSent] = useState<string[]>([]);
  const [problem, setProblem] = useState<Problem | null>(null);
  const take = useCallback((next: Bench) => {
    setBench(next);
    setProblem(null);
    setReadings((next.job?.readings ?? []).map(readingOf));
  }, []);
  const begin = useNews();
  const reload = useCallback(() => {
    const isNews = begin();
    answered(api.GET("/api/bench")).then((next) => { if (isNews()) take(next); },
      (fault: unknown) => { if (isNews()) setProblem(problemOf(fault)); });
  }, [begin, take]);
  const connection = useEvents({
    bench: (next: Bench) => { begin()(); take(next); },
    sent: ({ lines }: { lines: string[] }) => setSent(lines),
    reading: (came: Came) => setReadings((all) => [...all, readingOf(came)]),
  });
  useEffect(() => {
    if (connection === "open") reload();
  }, [connection, reload]);
  return { bench, readings, sent, connection, problem, reload };
}

// `shown`: as the bodies stand now. `seen`: readings that were asked for before the machine was
// drawn anew; the tip does not go to them once more.
interface Moving { job: number | null; bodies: number[]; shown: Pose[]; waiting: Pose[][]; asked: number; seen: number; frame: number; isAsking: boolean }

const nothingMoving = (job: number | null, seen: number): Moving => ({ job, bodies: [], shown: [], waiting: [], asked: 0, seen, frame: 0, isAsking: false });

// There at once, dots and all.
function stand(moving: Moving, world: World, poses: Pose[][]) {
  for (const pose of poses) world.dot(moving.bodies, pose);
  const last = poses.at(-1);
  if (!last) return;
  moving.shown = last;
  world.move(moving.bodies, last);
  world.countDots(Infinity);
}

// Goes on from what is shown to the next, quicker the more wait; straight, as the true way is
// not told. Where motion is unwanted it steps.
function follow(moving: Moving, world: World) {
  const isStepping = matchMedia("(prefers-reduced-motion: reduce)").matches;
  let begun = performance.now();
  const tick = (now: number) => {
    const next = moving.waiting[0];
    if (!next) { moving.frame = 0; return; }
    const share = (now - begun) / Math.max(30, 400 / moving.waiting.length);
    if (share >= 1) {
      begun = now;
      moving.shown = next;
      moving.waiting.shift();
      world.move(moving.bodies, next);
      world.dot(moving.bodies, next);
      world.countDots(Infinity);
    } else if (!isStepping) {
      world.move(moving.bodies, between(moving.shown, next, Math.max(0, share)));
    }
    moving.frame = requestAnimationFrame(tick);
  };
  moving.frame ||= requestAnimationFrame(tick);
}

export function useFollow(readings: LiveReading[], job: number | null, subject: Subject | null, data: SceneData | null, world: World | null): Problem | null {
  const [problem, setProblem] = useState<Problem | null>(null);
  const [round, setRound] = useState(0);
  const moving = useRef<Moving>(nothingMoving(null, 0));
  useEffect(() => {
    const was = moving.current;
    moving.current = nothingMoving(job, was.job === job ? Math.max(was.seen, was.asked) : 0);
    world?.clearDots();
    return () => cancelAnimationFrame(moving.current.frame);
  }, [job, subject, data, world]);
  useEffect(() => {
    const now = moving.current;
    const next = readings.slice(now.asked, now.asked + 400);
    if (now.isAsking || next.length === 0 || !subject || !data?.moves || !world) return;
    now.isAsking = true;
    const seen = Math.min(next.length, Math.max(0, now.seen - now.asked));
    now.asked += next.length;
    posesOf(subject, next.map((one) => one.at), new AbortController().signal).then((came) => {
      if (moving.current !== now) return;
      if (now.bodies.length === 0) now.shown = came.bodies.map((body) => data.poses[body]!);
      now.bodies = came.bodies;
      const there = (poses: (Pose[] | null)[]) => poses.filter((one) => one !== null);
      stand(now, world, there(came.poses.slice(0, seen)));
      now.waiting.push(...there(came.poses.slice(seen)));
      setProblem(null);
      follow(now, world);
    }, (fault: unknown) => setProblem(problemOf(fault))).finally(() => {
      now.isAsking = false;
      setRound((was) => was + 1);
    });
  }, [readings, round, job, subject, data, world]);
  return problem;
}
