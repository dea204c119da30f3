import { useMemo, useState } from "react";
import type { SceneData } from "../machine/data";
import { Lines, Stage } from "../machine/stage";
import { startIn, trackOf } from "../machine/transcript";
import { usePlayer } from "../machine/use_player";
import type { World } from "../machine/world";
import { posesIn, type Grid } from "./grid";

// What renders/playback writes.
export interface Playback {
  scenes: [Scene<SceneData>, ...Scene<Partial<SceneData>>[]];
  touches: number;
  transcript: string;
  lines: number;
}

interface Scene<Data> { exaggerate: number; scene: Data; grid: Grid; reach_mm: number | null }

const again = () => undefined;

function useScene(playback: Playback, isEnlarged: boolean) {
  return useMemo(() => {
    const [built, enlarged] = playback.scenes;
    const shown = (isEnlarged && enlarged) || built;
    return { data: { ...built.scene, ...shown.scene }, source: posesIn(shown.grid) };
  }, [playback, isEnlarged]);
}

function Cut({ playback }: { playback: Playback }) {
  const shown = useMemo(() => playback.transcript.split("\n").length - 1, [playback]);
  const of = playback.lines;
  if (shown >= of) return null;
  return (
    <p className="hint">The first {shown} of {of} lines are played: the report would grow too large with all.
      {" "}<code>caltwin run SCENARIO --transcript FILE</code> keeps every line.</p>
  );
}

export function Player({ playback }: { playback: Playback }) {
  const [world, setWorld] = useState<World | null>(null);
  const [isEnlarged, setEnlarged] = useState(false);
  const { data, source } = useScene(playback, isEnlarged);
  const [built, enlarged] = playback.scenes;
  const track = useMemo(
    () => trackOf(playback.transcript, startIn(built.scene.travel_mm), built.reach_mm), [playback, built]);
  const player = usePlayer(track, source, data, world);
  return (
    <div className="player">
      <div className="mac-grid">
        <div>
          <Stage shape={{ data, problem: null, again }} machine={data.machine} picture={null} onWorld={setWorld}
                 track={track} player={player} touches={playback.touches}>
            {enlarged ? (
              <label className="inline player-switch">
                <input type="checkbox" checked={isEnlarged} onChange={(event) => setEnlarged(event.target.checked)} />
                Errors drawn {enlarged.exaggerate} times as large
              </label>
            ) : null}
          </Stage>
        </div>
        <div>
          <Lines track={track} player={player} />
          <Cut playback={playback} />
        </div>
      </div>
    </div>
  );
}
