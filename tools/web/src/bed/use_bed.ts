import { useCallback, useEffect, useRef, useState } from "react";
import { answered, api, problemOf, type Problem, type Schemas } from "../api/client";
import { useEvents, useNews, type Connection } from "../api/events";
import type { BedStatus, BedTilt, Screws, Touch } from "./maths";

export type Grid = { rows: number; columns: number; reference: number };
export type Live = { points: number; touches: Touch[]; fault: string | null; ended: boolean };
export type Doing = "measure" | "apply" | null;

export type Bed = {
  status: BedStatus | null;
  current: BedTilt | null;
  past: BedTilt[];
  live: Live | null;
  doing: Doing;
  loading: boolean;
  problem: Problem | null;
  failed: { doing: Doing; problem: Problem } | null;
  before: BedTilt | null;
  moved: Screws | null;
  movedNotes: string[];
  connection: Connection;
  calibrate: (grid: Grid, before?: BedTilt) => Promise<void>;
  probe: (body: Schemas["ProbeRequest"]) => Promise<void>;
  apply: (offsets: Screws) => Promise<void>;
  reload: () => Promise<void>;
};

async function fetchCurrent(): Promise<BedTilt | null> {
  return answered(api.GET("/api/calibration/bed-tilt/current")).catch((fault: unknown) => {
    if (problemOf(fault).status === 404) return null;
    throw fault;
  });
}

async function fetchAll() {
  const status = await answered(api.GET("/api/calibration/bed-tilt/status"));
  const [current, history] = await Promise.all([
    status.is_measured ? fetchCurrent() : null,
    answered(api.GET("/api/calibration/bed-tilt/history")),
  ]);
  return { status, current, past: history.calibrations };
}

type Kept = { status: BedStatus | null; current: BedTilt | null; past: BedTilt[] };

function useKept() {
  const [kept, setKept] = useState<Kept>({ status: null, current: null, past: [] });
  const [loading, setLoading] = useState(true);
  const [fault, setFault] = useState<Problem | null>(null);
  const begin = useNews();
  const reload = useCallback(async () => {
    const isNews = begin();
    try {
      const next = await fetchAll();
      if (!isNews()) return;
      setKept(next);
      setFault(null);
    } catch (error) {
      if (isNews()) setFault(problemOf(error));
    }
    setLoading(false);
  }, [begin]);
  useEffect(() => void reload(), [reload]);
  return { kept, loading, fault, reload };
}

function useLive(reload: () => Promise<void>) {
  const [live, setLive] = useState<Live | null>(null);
  // The seat is left only after the event went out.
  const reloadSoon = () => window.setTimeout(() => void reload(), 150);
  const connection = useEvents({
    begin: ({ points }: { points: number }) => {
      setLive({ points, touches: [], fault: null, ended: false });
      void reload();
    },
    touch: (touch: Touch & { of: number }) =>
      setLive((was) => ({
        points: touch.of,
        touches: [...(was && !was.ended ? was.touches : []), touch],
        fault: null,
        ended: false,
      })),
    end: ({ fault }: { fault?: string }) => {
      setLive((was) => was && { ...was, fault: fault ?? null, ended: true });
      reloadSoon();
    },
    found: () => {
      setLive(null);
      reloadSoon();
    },
    applied: reloadSoon,
  });
  return { live, setLive, connection };
}

// Asks again after a lost connection, and while somebody is at the machine.
function useKeepUp(
  status: BedStatus | null,
  connection: Connection,
  reload: () => Promise<void>,
  setLive: (live: null) => void,
) {
  const wasLost = useRef(false);
  useEffect(() => {
    if (connection === "open" && wasLost.current) {
      setLive(null);
      void reload();
    }
    if (connection !== "connecting") wasLost.current = connection === "lost";
  }, [connection, reload, setLive]);
  const isHeld = status !== null && status.held_by !== null;
  useEffect(() => {
    if (!isHeld) return;
    const timer = window.setInterval(() => void reload(), 2000);
    return () => clearInterval(timer);
  }, [isHeld, reload]);
}

export function useBed(): Bed {
  const { kept, loading, fault, reload } = useKept();
  const { live, setLive, connection } = useLive(reload);
  const [doing, setDoing] = useState<Doing>(null);
  const [failed, setFailed] = useState<Bed["failed"]>(null);
  const [before, setBefore] = useState<BedTilt | null>(null);
  const [moved, setMoved] = useState<Screws | null>(null);
  const [movedNotes, setMovedNotes] = useState<string[]>([]);
  useKeepUp(kept.status, connection, reload, setLive);

  // What a success changes shows together with what the server then says of the bed.
  const act = async (what: Doing, go: () => Promise<() => void>) => {
    setDoing(what);
    setFailed(null);
    let onDone = () => {};
    try {
      onDone = await go();
    } catch (error) {
      setFailed({ doing: what, problem: problemOf(error) });
    }
    await reload();
    onDone();
    setLive((was) => (was?.ended ? was : null));
    setDoing(null);
  };
  const measured = (earlier: BedTilt | null) => () => {
    setBefore(earlier);
    setMoved(null);
  };
  return {
    ...kept, live, doing, loading, problem: fault, failed, before, moved, movedNotes, connection, reload,
    calibrate: (grid, earlier) => act("measure", async () => {
      const body = { grid_rows: grid.rows, grid_cols: grid.columns, reference_height: grid.reference };
      await answered(api.POST("/api/calibration/bed-tilt/calibrate", { body }));
      return measured(earlier ?? null);
    }),
    probe: (body) => act("measure", async () => {
      await answered(api.POST("/api/calibration/bed-tilt/probe", { body }));
      return measured(null);
    }),
    apply: (offsets) => act("apply", async () => {
      const done = await answered(api.POST("/api/calibration/bed-tilt/apply-triple-z", { body: offsets }));
      return () => {
        setMoved(done.moved);
        setMovedNotes(done.notes ?? []);
        setBefore(null);
      };
    }),
  };
}
