import { useMemo, useState } from "react";
import { campaignName, endingOf, featureName, jobName } from "../calibrate/words";
import { Card, Notice, ProblemNotice } from "../ui/parts";
import { picturePath, type Subject } from "./ask";
import { useBenchLive, useFollow, type Bench, type LiveHold } from "./use_live";
import { useShape } from "./use_shape";
import { Exaggeration, MachineView } from "./view";
import type { World } from "./world";

function stateText({ bench }: LiveHold): string {
  if (!bench) return "";
  const what = bench.job ? jobName(bench.job) : "a procedure";
  if (bench.state === "working") return `At work: ${what}.`;
  if (bench.state === "asking") return `${what} waits for somebody at the machine to answer.`;
  const ended = bench.job?.result ? ` ${endingOf(bench.job.result.ending).verdict}` : "";
  return bench.job ? `Nothing is at work. The last was: ${what}.${ended}` : "Nothing is at work, and nothing was.";
}

function Readings({ hold }: { hold: LiveHold }) {
  const last = hold.readings.slice(-8).reverse();
  if (last.length === 0) {
    return <p className="hint">No reading yet. Start a procedure on the page <a href="/calibrate">Calibrate</a>, in this window or another; the machine here follows it.</p>;
  }
  return (
    <>
      <h3>The newest of {hold.readings.length} readings</h3>
      <div className="scroll" tabIndex={0} role="group" aria-label="The newest readings">
        <table>
          <thead><tr><th scope="col">Of</th><th scope="col" className="number">X, Y, Z in mm</th><th scope="col" className="number">Read in mm</th></tr></thead>
          <tbody>
            {last.map((one, i) => (
              <tr key={hold.readings.length - i}>
                <td>{campaignName(one.campaign)} <span className="hint">{featureName(one.feature)}</span></td>
                <td className="number">{one.at.map((value) => value.toFixed(3)).join(", ")}</td>
                <td className="number">{one.value.toFixed(4)}</td>
              </tr>
            ))}
          </tbody>
        </table>
      </div>
      <p className="hint">One reading each. How far such readings scatter is in the procedure's result on the page Calibrate.</p>
    </>
  );
}

// Not read out as it comes: it changes ten times a second.
function Sent({ lines }: { lines: string[] }) {
  if (lines.length === 0) return null;
  return (
    <>
      <h3>The newest lines of G-code</h3>
      <ol className="mac-sent" aria-label="The newest lines of G-code">{lines.map((line, i) => <li key={i}><code>{line}</code></li>)}</ol>
    </>
  );
}

const lying: Record<Bench["artefacts"][number]["type"], string> = {
  block123: "the 1-2-3 block", web: "a thin wall", ring: "a ring", pocket: "a pocket", ledge: "a ledge", plate: "a plate",
};

function lyingText({ type, size_mm }: Bench["artefacts"][number]): string {
  return size_mm ? `${lying[type]} (${size_mm.map((mm) => Number(mm.toFixed(1))).join(" × ")} mm)` : lying[type];
}

// What of the machine is drawn, and what is not.
function Drawn({ bench, moves }: { bench: Bench; moves: boolean }) {
  const lies = bench.artefacts.length > 0;
  const how = moves ? "The tip goes straight to the place of each reading as it comes." : "This machine has no tip to follow, so it is shown standing still.";
  if (bench.is_twin) {
    return (
      <p className="hint">{how} The machine is simulated and drawn with the errors hidden in it. What a setting corrects is not drawn, nor is a wrong steps/mm.
        {lies ? ` On its table: ${bench.artefacts.map(lyingText).join(", ")}. The dots are where it was touched.` : ""}</p>
    );
  }
  return (
    <p className="hint">{how} It is drawn without the machine's errors: it is a real machine, whose errors nobody knows, so there is nothing to enlarge.
      {lies ? " The workpiece is not drawn: the server does not know where it lies. The dots are where it was touched." : ""}</p>
  );
}

export function Live() {
  const hold = useBenchLive();
  const [world, setWorld] = useState<World | null>(null);
  const machine = hold.bench?.machine ?? null;
  const isTwin = hold.bench?.is_twin ?? false;
  const [exaggerate, setExaggerate] = useState(1);
  const subject = useMemo<Subject | null>(
    () => (!machine ? null : isTwin ? { of: "bench", name: machine, exaggerate } : { of: "machines", name: machine, exaggerate: 1 }),
    [machine, isTwin, exaggerate]);
  const shape = useShape(subject);
  const fault = useFollow(hold.readings, hold.bench?.job?.id ?? null, shape.of, shape.data, world);
  return (
    <div className="mac-grid">
      <Card title={machine ? `The machine of “Calibrate”: ${machine}` : "The machine of “Calibrate”"}>
        {machine ? (
          <MachineView shape={shape} machine={machine} picture={picturePath(machine)} onWorld={setWorld}>
            {isTwin && shape.data ? <Exaggeration value={exaggerate} set={setExaggerate} /> : null}
          </MachineView>
        ) : null}
        {hold.bench && shape.data ? <Drawn bench={hold.bench} moves={shape.data.moves} /> : null}
      </Card>
      <Card title="What it does">
        {hold.connection === "lost" ? <Notice kind="warn"><p><strong>The connection to the server is lost.</strong> If the server still runs, so does what is at work. This page follows again when the connection is back.</p></Notice> : null}
        {hold.problem ? <><ProblemNotice problem={hold.problem} /><button type="button" onClick={hold.reload}>Try again</button></> : null}
        {fault ? <ProblemNotice problem={fault} /> : null}
        <p role="status">{stateText(hold)}{hold.bench?.held_by ? ` At the machine: ${hold.bench.held_by}.` : ""}</p>
        <Sent lines={hold.sent} />
        <Readings hold={hold} />
      </Card>
    </div>
  );
}
