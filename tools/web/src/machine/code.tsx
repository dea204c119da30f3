import { useEffect, useRef } from "react";
import { ProblemNotice } from "../ui/parts";
import type { Track } from "./transcript";
import { speeds, type Player } from "./use_player";

const shown = 40;

const markWords = { setting: "setting", touch: "touch", home: "home" } as const;

export function Code({ track, player }: { track: Track; player: Player }) {
  const box = useRef<HTMLOListElement>(null);
  const current = track.steps[player.step]?.line ?? 0;
  const first = Math.max(0, Math.min(track.lines.length - shown, current - shown / 2));
  useEffect(() => {
    const line = box.current?.querySelector<HTMLElement>("[aria-current]");
    if (box.current && line) box.current.scrollTop = line.offsetTop - box.current.clientHeight / 2 + line.clientHeight;
  }, [current]);
  return (
    <ol className="mac-code" ref={box} tabIndex={0} aria-label={`G-code, lines ${first + 1} to ${Math.min(track.lines.length, first + shown)} of ${track.lines.length}`}>
      {track.lines.slice(first, first + shown).map((line, i) => (
        <li key={first + i} value={first + i + 1} className={`${line.isSent ? "sent" : "answer"} ${line.mark ?? ""}`}
            aria-current={first + i === current ? "step" : undefined} onClick={() => player.goTo(line.step)}>
          <span className="mac-number" aria-hidden="true">{first + i + 1}</span>
          <code>{line.isSent ? "" : "← "}{line.text}</code>
          {line.mark ? <span className={`mac-mark ${line.mark}`}>{markWords[line.mark]}</span> : null}
        </li>
      ))}
    </ol>
  );
}

export function Settings({ track, player }: { track: Track; player: Player }) {
  const changes = track.steps.flatMap((step, i) => (step.mark === "setting" ? [{ step, i }] : []));
  if (changes.length === 0) return <p className="hint">No setting is changed in this run.</p>;
  return (
    <details>
      <summary>{changes.length === 1 ? "One change of a setting" : `${changes.length} changes of settings`}</summary>
      <ul className="mac-changes">
        {changes.slice(0, 100).map(({ step, i }) => (
          <li key={i}><button type="button" className="quiet" onClick={() => player.goTo(i)}>line {step.line + 1}: <code>{step.text}</code></button></li>
        ))}
      </ul>
      {changes.length > 100 ? <p className="hint">The first 100 are listed. The whole transcript has all.</p> : null}
    </details>
  );
}

const clock = (seconds: number) => {
  const whole = Math.round(seconds);
  return whole < 60 ? `${whole} s` : `${Math.floor(whole / 60)} min ${String(whole % 60).padStart(2, "0")} s`;
};

export function Controls({ track, player }: { track: Track; player: Player }) {
  const last = track.steps.length - 1;
  const step = track.steps[player.step];
  const [x = 0, y = 0, z = 0] = step ? track.points[step.last] ?? [] : [];
  return (
    <div className="mac-controls" role="group" aria-label="Playback">
      <div className="mac-buttons">
        <button type="button" className="quiet" onClick={() => player.goTo(player.step - 1)} disabled={player.step === 0}>◂ Line back</button>
        <button type="button" onClick={player.isPlaying ? player.pause : player.play}>{player.isPlaying ? "Pause" : "Play"}</button>
        <button type="button" className="quiet" onClick={() => player.goTo(player.step + 1)} disabled={player.step >= last}>Line on ▸</button>
        <label className="inline">Speed
          <select value={player.speed} onChange={(event) => player.setSpeed(Number(event.target.value))}>
            {speeds.map((speed) => <option key={speed} value={speed}>{speed === 1 ? "as the machine" : `${speed} times`}</option>)}
          </select>
        </label>
      </div>
      <label className="mac-slider">Where in the run: {clock(step?.end ?? 0)} of {clock(track.times.at(-1) ?? 0)}
        <input type="range" min={0} max={Math.max(1, last)} step={1} value={player.step}
               aria-valuetext={`command ${player.step + 1} of ${last + 1}: ${step?.text ?? ""}`}
               onChange={(event) => player.goTo(Number(event.target.value))} />
      </label>
      <p className="mac-now">
        <code>{step?.text ?? ""}</code>
        <span className="hint"> ends at X {x.toFixed(3)}, Y {y.toFixed(3)}, Z {z.toFixed(3)} mm</span>
        {player.isWaiting ? <span className="hint"> · waiting for the machine's poses</span> : null}
      </p>
      {player.isOutOfReach ? <p className="hint">The machine does not reach this place; it is shown where it was last.</p> : null}
      {player.problem ? <><ProblemNotice problem={player.problem} /><button type="button" onClick={player.again}>Try again</button></> : null}
    </div>
  );
}

export function PlainTranscript({ text }: { text: string }) {
  return (
    <pre className="mac-plain" tabIndex={0} role="group" aria-label="Transcript">{text}</pre>
  );
}
