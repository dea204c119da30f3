import { useCallback, useEffect, useRef, useState } from "react";
import { answered, api, operatorName, problemOf, type Problem, type Schemas } from "../api/client";
import { useEvents, useNews, type Connection } from "../api/events";
import { readEntries, type Bench, type Entries, type Reading } from "./model";

type Session = Schemas["Session"];
type Kept = Record<string, unknown>;
type Open = Record<string, never>; // what the generated client calls an object of any keys

export interface BenchHold {
  bench: Bench | null;
  entries: Entries;
  connection: Connection;
  readings: Reading[];
  said: string[];
  problem: Problem | null;
  isSaved: boolean;
  // The newest job that this browser began.
  followed: number;
  clearProblem: () => void;
  retry: () => void;
  keep: (change: Partial<Entries>) => void;
  claim: (queue: Entries["queue"], change: Partial<Entries>) => Promise<boolean>;
  run: (procedure: string, options: Record<string, unknown>) => Promise<boolean>;
  answer: (id: number, yes: boolean, value?: number) => Promise<boolean>;
  answerQuietly: (id: number, value?: number) => void;
  abort: () => void;
  restore: () => void;
}

const patch = (version: number, entries: Kept) =>
  api.PATCH("/api/bench/session", { body: { version, entries: entries as Open } });

function useRetries(waiting: Kept, connection: Connection, flush: () => Promise<void>) {
  useEffect(() => {
    if (connection === "open") void flush();
  }, [connection, flush]);
  useEffect(() => {
    if (Object.keys(waiting).length === 0) return;
    const again = setInterval(() => void flush(), 1500);
    return () => clearInterval(again);
  }, [waiting, flush]);
}

// Keeps entries on the server. Changes wait in `pending` until they are there; somebody
// else's newer entries are taken and ours put on top.
function useSession(take: (session: Session) => void, connection: Connection) {
  const pending = useRef<Kept>({});
  const known = useRef<Session>({ version: 0, entries: {} });
  const flushing = useRef<Promise<void> | null>(null);
  const [waiting, setWaiting] = useState<Kept>({});

  const settle = useCallback((session: Session) => {
    if (session.version < known.current.version) return;
    known.current = session;
    take(session);
  }, [take]);

  const write = useCallback(async () => {
    for (let tries = 0; Object.keys(pending.current).length > 0 && tries < 8; ++tries) {
      const sent = pending.current;
      const { data, error, response } = await patch(known.current.version, { ...known.current.entries, ...sent })
        .catch((fault: unknown) => ({ data: undefined, error: fault, response: undefined }));
      if (data) {
        pending.current = Object.fromEntries(Object.entries(pending.current).filter(([key, value]) => sent[key] !== value));
        settle(data);
        setWaiting(pending.current);
      } else if (response?.status === 409) {
        settle(error as unknown as Session);
      } else {
        return;
      }
    }
  }, [settle]);

  const flush = useCallback((): Promise<void> => {
    flushing.current ??= write().finally(() => { flushing.current = null; });
    return flushing.current;
  }, [write]);

  const keep = useCallback((change: Partial<Entries>) => {
    pending.current = { ...pending.current, ...change };
    setWaiting(pending.current);
    void flush().then(flush);
  }, [flush]);

  // Of several tabs that want to go on with the next axis, one gets true.
  const claim = useCallback(async (queue: Entries["queue"], change: Partial<Entries>) => {
    await flush();
    if (JSON.stringify(readEntries(known.current.entries).queue) !== JSON.stringify(queue)) return false;
    const { data } = await patch(known.current.version, { ...known.current.entries, ...change })
      .catch(() => ({ data: undefined }));
    if (data) settle(data);
    return data !== undefined;
  }, [flush, settle]);

  useRetries(waiting, connection, flush);
  return { waiting, keep, claim, settle, flush };
}

// What `bench` said last, and the readings and sentences that came since.
function useLive() {
  const [bench, setBench] = useState<Bench | null>(null);
  const [readings, setReadings] = useState<Reading[]>([]);
  const [said, setSaid] = useState<string[]>([]);
  const takeBench = useCallback((next: Bench) => {
    setBench((now) => (now && now.session.version > next.session.version ? { ...next, session: now.session } : next));
    setReadings((next.job?.readings ?? []) as unknown as Reading[]);
    setSaid(next.job?.said ?? []);
  }, []);
  const takeSession = useCallback((session: Session) => {
    setBench((now) => (now ? { ...now, session } : now));
  }, []);
  return { bench, readings, said, setReadings, setSaid, takeBench, takeSession };
}

const send = (id: number, yes: boolean, value?: number) => answered(api.POST("/api/bench/answer",
  { body: value === undefined ? { id, yes } : { id, yes, value_mm: value } }));

export function useBench(): BenchHold {
  const live = useLive();
  const { takeBench } = live;
  const [problem, setProblem] = useState<Problem | null>(null);
  // Not told from what is rendered: a quick job may begin and end between two renders.
  const [followed, setFollowed] = useState(0);
  const settleRef = useRef<(session: Session) => void>(() => undefined);
  const take = useCallback((next: Bench) => {
    takeBench(next);
    if (next.job && next.held_by === operatorName()) setFollowed(next.job.id);
    settleRef.current(next.session);
  }, [takeBench]);
  const begin = useNews();
  const connection = useEvents({
    bench: (next: Bench) => { begin()(); take(next); },
    said: (one: { text: string }) => live.setSaid((now) => [...now, one.text]),
    reading: (one: Reading) => live.setReadings((now) => [...now, one]),
  });
  const session = useSession(live.takeSession, connection);
  settleRef.current = session.settle;

  const retry = useCallback(() => {
    const isNews = begin();
    answered(api.GET("/api/bench")).then((next) => { setProblem(null); if (isNews()) take(next); },
      (fault: unknown) => { if (isNews()) setProblem(problemOf(fault)); });
  }, [begin, take]);
  useEffect(retry, [retry, connection]);

  const tried = async (asked: Promise<unknown>): Promise<boolean> => {
    setProblem(null);
    return asked.then(() => true, (fault: unknown) => { setProblem(problemOf(fault)); return false; });
  };
  const entries = readEntries({ ...(live.bench?.session.entries ?? {}), ...session.waiting });
  return {
    bench: live.bench, entries, connection, readings: live.readings, said: live.said, problem, retry, followed,
    isSaved: Object.keys(session.waiting).length === 0,
    clearProblem: () => setProblem(null),
    keep: session.keep, claim: session.claim,
    // Entries first: the server keeps both in one file.
    run: (procedure, options) => tried(session.flush()
      .then(() => answered(api.POST("/api/bench/procedures", { body: { procedure, options: options as Open } })))
      .then((job) => setFollowed(job.id))),
    answer: (id, yes, value) => tried(send(id, yes, value)),
    // Of two tabs one comes too late; the other's answer is as good.
    answerQuietly: (id, value) => void send(id, true, value).catch(() => undefined),
    abort: () => void tried(answered(api.POST("/api/bench/abort"))),
    restore: () => void tried(answered(api.POST("/api/bench/restore"))),
  };
}
