import { useMemo, useState } from "react";
import { campaignName, endingOf, featureName, jobName } from "../calibrate/words";
import { Card, Notice, ProblemNotice } from "../ui/parts";
import { picturePath, type Subject } from "./ask";
import { useBenchLive, useFollow, type LiveHold } from "./use_live";
import { useShape } from "./use_shape";
import { MachineView } from "./view";
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

export function Live() {
  const hold = useBenchLive();
  const [world, setWorld] = useState<World | null>(null);
  const machine = hold.bench?.machine ?? null;
  const subject = useMemo<Subject | null>(() => (machine ? { of: "machines", name: machine, exaggerate: 1 } : null), [machine]);
  const shape = useShape(subject);
  const fault = useFollow(hold.readings, hold.bench?.job?.id ?? null, shape.of, shape.data, world);
  return (
    <div className="mac-grid">
      <Card title={machine ? `The machine of “Calibrate”: ${machine}` : "The machine of “Calibrate”"}>
        {machine ? <MachineView shape={shape} machine={machine} picture={picturePath(machine)} onWorld={setWorld} /> : null}
        {shape.data ? <p className="hint">The tip goes straight to the place of each reading as it comes. It is drawn without the machine's errors: those are not known, so there is nothing to enlarge.
          {hold.bench?.artefacts?.length ? " The workpiece is not drawn: the server does not tell where it stands. The dots are where it was touched." : ""}</p> : null}
      </Card>
      <Card title="What it does">
        {hold.connection === "lost" ? <Notice kind="warn"><p><strong>The connection to the server is lost.</strong> What is at work goes on there. This page follows again when the connection is back.</p></Notice> : null}
        {hold.problem ? <><ProblemNotice problem={hold.problem} /><button type="button" onClick={hold.reload}>Try again</button></> : null}
        {fault ? <ProblemNotice problem={fault} /> : null}
        <p role="status">{stateText(hold)}{hold.bench?.held_by ? ` At the machine: ${hold.bench.held_by}.` : ""}</p>
        <Readings hold={hold} />
      </Card>
    </div>
  );
}
