import { useState } from "react";
import { useScenarios } from "../machine/choose";
import { Live } from "../machine/live";
import "../machine/machine.css";
import { Playback } from "../machine/playback";
import { useRun } from "../machine/use_run";

const asked = () => new URLSearchParams(location.search).get("scenario");

export default function MachinePage() {
  const all = useScenarios();
  const run = useRun();
  const [isLive, setLive] = useState(false);
  const [name, setName] = useState(asked() ?? run.done?.scenario ?? null);
  const chosen = all.scenarios?.find((one) => one.name === name) ?? null;
  const choose = (next: string) => {
    setName(next);
    history.replaceState(null, "", `?scenario=${encodeURIComponent(next)}`);
  };
  return (
    <>
      <h1>Machine</h1>
      <div className="mac-modes" role="group" aria-label="What to watch">
        <button type="button" className={isLive ? "quiet" : undefined} aria-pressed={!isLive} onClick={() => setLive(false)}>Play a run back</button>
        <button type="button" className={isLive ? undefined : "quiet"} aria-pressed={isLive} onClick={() => setLive(true)}>Watch the machine live</button>
      </div>
      {isLive ? <Live /> : <Playback all={all} chosen={chosen} run={run} onChoose={choose} />}
    </>
  );
}
