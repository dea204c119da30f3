import type { ReactNode } from "react";
import { Code, Controls, Settings } from "./code";
import type { Track } from "./transcript";
import type { Player } from "./use_player";
import { MachineView, type Drawing } from "./view";
import type { World } from "./world";

// The machine with what plays it. `children` belong to the drawing in 3D.
export function Stage({ shape, machine, picture, onWorld, track, player, touches, children }: {
  shape: Drawing;
  machine: string;
  picture: string | null;
  onWorld: (world: World | null) => void;
  track: Track | null;
  player: Player;
  touches: number;
  children?: ReactNode;
}) {
  return (
    <>
      <MachineView shape={shape} machine={machine} picture={picture} onWorld={onWorld}>{children}</MachineView>
      {track ? <Controls track={track} player={player} /> : null}
      {track && touches > 0 && track.steps.every((step) => step.touch === null) ? (
        <p className="hint">The controller probes by itself in this run. Those moves are not in the transcript, so they cannot be shown.</p>
      ) : null}
      {track ? <Legend hasTouches={track.steps.some((step) => step.touch !== null)} /> : null}
    </>
  );
}

// What is sent, beside it.
export function Lines({ track, player }: { track: Track; player: Player }) {
  return (
    <>
      <Code track={track} player={player} />
      <Settings track={track} player={player} />
    </>
  );
}

function Legend({ hasTouches }: { hasTouches: boolean }) {
  return (
    <ul className="mac-legend">
      {hasTouches ? <li><span className="mac-dot" aria-hidden="true" /> where something was touched (also seen through what is in front)</li> : null}
      <li>The machine is drawn with the errors hidden in it at the start. What a setting corrects during the run is not drawn.</li>
      <li>Times follow the feed rates (F) of the lines; accelerations are left out.</li>
    </ul>
  );
}
