import { useMemo, useState } from "react";
import { Busy, Card, ProblemNotice } from "../ui/parts";
import type { SceneData, Subject } from "./ask";
import { Choose, type Scenario, type useScenarios } from "./choose";
import { Code, Controls, PlainTranscript, Settings } from "./code";
import { Result, Verdict } from "./result";
import { trackOf, type Point } from "./transcript";
import { usePlayer } from "./use_player";
import type { RunHold } from "./use_run";
import { Exaggeration, MachineView, useShape } from "./view";
import type { World } from "./world";

// The middle of the travel: where a run begins whose first lines do not say.
const startOf = (travel: number[][], kinematics: string): Point => {
  const middle = (axis: number) => (kinematics === "delta" ? 0 : ((travel[axis]?.[0] ?? 0) + (travel[axis]?.[1] ?? 0)) / 2);
  return [middle(0), middle(1), 10];
};

function useTrack(run: RunHold, chosen: Scenario | null, data: SceneData | null) {
  const transcript = run.done && run.done.scenario === chosen?.name ? run.done.transcript : "";
  const kinematics = chosen?.kinematics ?? "";
  const travel = data ? JSON.stringify(data.travel_mm) : "";
  return useMemo(() => {
    if (!transcript || !travel || !data?.moves) return null;
    const track = trackOf(transcript, startOf(JSON.parse(travel) as number[][], kinematics), kinematics === "delta" ? 15 : 1e9);
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
  const player = usePlayer(track, shape.of, shape.data, world);
  const done = run.done && run.done.scenario === name ? run.done : null;
  const isStill = (shape.problem !== null && !shape.data) || shape.data?.moves === false;
  return (
    <>
      <Start all={all} chosen={chosen} run={run} onChoose={onChoose} />
      <p className="mac-unseen" aria-live="polite">{run.running ? "The run is at work." : done ? "The run has ended. Its result is below." : ""}</p>
      {chosen ? (
        <div className="mac-grid">
          <Card title={`The machine: ${chosen.machine}`}>
            <MachineView shape={shape} machine={chosen.machine} onWorld={setWorld}>
              {shape.data?.moves === false ? <p className="hint">This machine has no tip to follow, so it is shown standing still.</p>
                : <Exaggeration value={exaggerate} set={(value) => setExaggeration({ of: name, value })} />}
            </MachineView>
            {track ? <Controls track={track} player={player} /> : null}
            {track && (done?.result?.touches ?? 0) > 0 && track.steps.every((step) => step.touch === null) ? (
              <p className="hint">The controller probes by itself in this run. Those moves are not in the transcript, so they cannot be shown.</p>
            ) : null}
            {track ? <Legend /> : null}
          </Card>
          <Card title="G-code">
            {run.running ? <Busy text="It comes when the run is done" />
              : !done ? <p className="hint">What is sent to the controller is shown here once the scenario has run.</p>
                : track ? <><Code track={track} player={player} /><Settings track={track} player={player} /></>
                  : done.transcript && isStill ? <PlainTranscript text={done.transcript} />
                    : shape.isLoading ? <Busy text="Loading the machine" /> : <p>{done.state === "done" ? "Nothing was sent in this run." : "There is no transcript of this run."}</p>}
          </Card>
        </div>
      ) : null}
      {done ? <Result done={done} /> : null}
    </>
  );
}

function Legend() {
  return (
    <ul className="mac-legend">
      <li><span className="mac-dot" aria-hidden="true" /> where something was touched (also seen through what is in front)</li>
      <li>The machine is drawn with the errors hidden in it at the start. What a setting corrects during the run is not drawn.</li>
      <li>Times follow the feed rates (F) of the lines; accelerations are left out.</li>
    </ul>
  );
}
