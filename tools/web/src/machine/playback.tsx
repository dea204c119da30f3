import { useMemo, useState } from "react";
import { Busy, Card, ProblemNotice } from "../ui/parts";
import { picturePath, posesFrom, type Subject } from "./ask";
import { Choose, type Scenario, type useScenarios } from "./choose";
import { PlainTranscript } from "./code";
import type { SceneData } from "./data";
import { Result, Verdict } from "./result";
import { Lines, Stage } from "./stage";
import { startIn, trackOf } from "./transcript";
import { usePlayer } from "./use_player";
import type { RunHold } from "./use_run";
import { useShape } from "./use_shape";
import { Exaggeration } from "./view";
import type { World } from "./world";

function useTrack(run: RunHold, chosen: Scenario | null, data: SceneData | null) {
  const transcript = run.done && run.done.scenario === chosen?.name ? run.done.transcript : "";
  const kinematics = chosen?.kinematics ?? "";
  const travel = data ? JSON.stringify(data.travel_mm) : "";
  return useMemo(() => {
    if (!transcript || !travel || !data?.moves) return null;
    const track = trackOf(transcript, startIn(JSON.parse(travel) as number[][]), kinematics === "delta" ? 15 : null);
    return track.steps.length > 0 ? track : null;
  }, [transcript, travel, kinematics, data?.moves]);
}

function Start({ all, chosen, run, onChoose }: {
  all: ReturnType<typeof useScenarios>;
  chosen: Scenario | null;
  run: RunHold;
  onChoose: (name: string) => void;
}) {
  return (
    <Card title="Choose a run">
      <Choose all={all} chosen={chosen} onChoose={onChoose} isBusy={run.running !== null} />
      <div className="row">
        <button type="button" disabled={!chosen || run.running !== null} onClick={() => chosen && void run.begin(chosen.name)}>
          {run.done && run.done.scenario === chosen?.name ? "Run it again" : "Run it"}
        </button>
        {run.running ? (
          <>
            <Busy text={run.isStopping ? "Stopping" : "The run is at work"} />
            <button type="button" className="danger" disabled={!run.running.id || run.isStopping} onClick={() => void run.stop()}>Stop the run</button>
          </>
        ) : null}
      </div>
      {run.done?.result && run.done.scenario === chosen?.name ? <Verdict result={run.done.result} isLinked /> : null}
      {run.problem ? <ProblemNotice problem={run.problem} /> : null}
    </Card>
  );
}

export function Playback({ all, chosen, run, onChoose }: {
  all: ReturnType<typeof useScenarios>;
  chosen: Scenario | null;
  run: RunHold;
  onChoose: (name: string) => void;
}) {
  const [world, setWorld] = useState<World | null>(null);
  const name = chosen?.name ?? null;
  const [exaggeration, setExaggeration] = useState({ of: name, value: 1 });
  const exaggerate = exaggeration.of === name ? exaggeration.value : 1;
  const subject = useMemo<Subject | null>(() => (name ? { of: "scenarios", name, exaggerate } : null), [name, exaggerate]);
  const shape = useShape(subject);
  const track = useTrack(run, chosen, shape.data);
  const poses = useMemo(() => (shape.of ? posesFrom(shape.of) : null), [shape.of]);
  const player = usePlayer(track, poses, shape.data, world);
  const done = run.done && run.done.scenario === name ? run.done : null;
  const isStill = (shape.problem !== null && !shape.data) || shape.data?.moves === false;
  return (
    <>
      <Start all={all} chosen={chosen} run={run} onChoose={onChoose} />
      <p className="mac-unseen" aria-live="polite">{run.running ? "The run is at work." : done ? "The run has ended. Its result is below." : ""}</p>
      {chosen ? (
        <div className="mac-grid">
          <Card title={`The machine: ${chosen.machine}`}>
            <Stage shape={shape} machine={chosen.machine} picture={picturePath(chosen.machine)} onWorld={setWorld}
                   track={track} player={player} touches={done?.result?.touches ?? 0}>
              {shape.data?.moves === false ? <p className="hint">This machine has no tip to follow, so it is shown standing still.</p>
                : <Exaggeration value={exaggerate} set={(value) => setExaggeration({ of: name, value })} />}
            </Stage>
          </Card>
          <Card title="G-code">
            {run.running ? <Busy text="It comes when the run is done" />
              : !done ? <p className="hint">What is sent to the controller is shown here once the scenario has run.</p>
                : track ? <Lines track={track} player={player} />
                  : done.transcript && isStill ? <PlainTranscript text={done.transcript} />
                    : shape.isLoading ? <Busy text="Loading the machine" /> : <p>{done.state === "done" ? "Nothing was sent in this run." : "There is no transcript of this run."}</p>}
          </Card>
        </div>
      ) : null}
      {done ? <Result done={done} /> : null}
    </>
  );
}
