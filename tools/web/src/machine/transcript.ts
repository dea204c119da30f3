// What a run sent and was answered, as steps of the tip along a line of time.
export type Point = [number, number, number];

export interface Line { text: string; isSent: boolean; step: number; mark: Mark }

export type Mark = "setting" | "touch" | "home" | null;

export interface Step {
  line: number;
  text: string;
  mark: Mark;
  // When it ends, in seconds of the machine since the start.
  end: number;
  last: number; // index of the waypoint at which it ends
  // The waypoint at which something was touched.
  touch: number | null;
}

export interface Track {
  lines: Line[];
  steps: Step[];
  points: Point[];
  times: number[];
}

const shortest = 0.05;
const clearance = 10;
const settings = /^(?:(?:M92|M201|M203|M204|M206|M208|M210|M211|M421|M425|M500|M558|M566|M579|M584|M665|M666|M669|M671|M81[0-7]|M851|G10|G31)\b.*[A-Z]\s*[-"]?\d|M500\b|set |SET_|SAVE_|\$\d+=)/i;

const wordsOf = (text: string): Partial<Record<string, number>> => {
  const found: Partial<Record<string, number>> = {};
  for (const [, letter = "", value] of text.matchAll(/([A-Z])\s*(-?\d*\.?\d+)/gi)) found[letter.toUpperCase()] ??= Number(value);
  return found;
};

const axes = ["X", "Y", "Z"] as const;

// Where an answer says the tip stands: M114 and homing, a probe's answer of Grbl.
function standsAt(answers: string[]): Partial<Record<string, number>> | null {
  for (const answer of answers) {
    const probed = /\[PRB:(-?[\d.]+),(-?[\d.]+),(-?[\d.]+):1\]/.exec(answer);
    if (probed) return { X: Number(probed[1]), Y: Number(probed[2]), Z: Number(probed[3]) };
    const said = /^X:\s*(-?[\d.]+) Y:\s*(-?[\d.]+) Z:\s*(-?[\d.]+)/.exec(answer);
    if (said) return { X: Number(said[1]), Y: Number(said[2]), Z: Number(said[3]) };
  }
  return null;
}

// Heights that G30 found: RepRapFirmware's and Marlin's words.
function heightOf(answers: string[]): number | null {
  const found = /(?:Stopped at height|Bed X: \S+ Y: \S+ Z:)\s*(-?[\d.]+)/.exec(answers.join("\n"));
  return found ? Number(found[1]) : null;
}

class Reader {
  points: Point[] = [];
  times: number[] = [];
  time = 0;
  private isRelative = false;
  private feed = 3000;
  constructor(private at: Point, private reach: number) {
    this.points.push(at);
    this.times.push(0);
  }

  private goTo(next: Point, feed = this.feed) {
    const from = this.at;
    const long = Math.hypot(next[0] - from[0], next[1] - from[1], next[2] - from[2]);
    const parts = Math.max(1, Math.ceil(long / this.reach));
    for (let i = 1; i <= parts; i++) {
      this.time += long === 0 ? 0 : (long / parts) / (Math.max(1, feed) / 60);
      this.points.push(axes.map((_, k) => from[k]! + ((next[k]! - from[k]!) * i) / parts) as Point);
      this.times.push(this.time);
    }
    this.at = next;
  }

  private target(words: Partial<Record<string, number>>, relative: boolean): Point {
    return axes.map((axis, k) => (words[axis] === undefined ? this.at[k]! : words[axis]! + (relative ? this.at[k]! : 0))) as Point;
  }

  // Answers of the line itself, and of the M114 that asks where a probe move ended.
  take(text: string, answers: string[], next: string[] | null): number | null {
    const command = /\b(G0|G1|G28|G30|G38\.\d|G90|G91|G92)(?![\d.])/i.exec(text.replace(/\bG53\b/i, ""))?.[1]?.toUpperCase();
    const words = wordsOf(text.replace(/\b(?:G53|G0|G1|G28|G30|G38\.\d|G9\d)(?![\d.])/gi, ""));
    const isMachine = /\bG53\b/i.test(text);
    if (words.F && command) this.feed = words.F;
    if (command === "G90") this.isRelative = false;
    if (command === "G91") this.isRelative = true;
    if (command === "G92") this.at = this.target(words, false);
    if (command === "G0" || command === "G1") this.goTo(this.target(words, this.isRelative && !isMachine), command === "G0" && !words.F ? 6000 : this.feed);
    if (command === "G38.2" || command === "G38.3" || command === "G38.4" || command === "G38.5") {
      const stop = standsAt(answers) ?? (next ? standsAt(next) : null);
      this.goTo(stop ? this.target(stop, false) : this.target(words, this.isRelative && !isMachine));
      return stop && command < "G38.4" ? this.points.length - 1 : null;
    }
    if (command === "G30") return this.sink(words, heightOf(answers));
    if (command === "G28" || /^M114\b/i.test(text)) {
      const stands = standsAt(answers) ?? (command === "G28" && next ? standsAt(next) : null);
      if (stands) this.goTo(this.target(stands, false), 6000);
    }
    return null;
  }

  private sink(words: Partial<Record<string, number>>, height: number | null): number | null {
    this.goTo([this.at[0], this.at[1], clearance], 6000);
    this.goTo([words.X ?? this.at[0], words.Y ?? this.at[1], clearance], 6000);
    if (height === null) return null;
    this.goTo([this.at[0], this.at[1], height], 600);
    const touch = this.points.length - 1;
    this.goTo([this.at[0], this.at[1], clearance], 1200);
    return touch;
  }

  // Nothing passes in no time, or stepping through it would show nothing.
  close(from: number) {
    if (this.time - from >= shortest) return;
    this.time = from + shortest;
    this.points.push(this.at);
    this.times.push(this.time);
  }
}

function markOf(text: string, touch: number | null): Mark {
  if (touch !== null) return "touch";
  if (/\bG28\b/i.test(text)) return "home";
  return settings.test(text) ? "setting" : null;
}

// The middle of the travel: where a run begins whose first lines do not say.
export function startIn(travel: number[][]): Point {
  const middle = (axis: number) => ((travel[axis]?.[0] ?? 0) + (travel[axis]?.[1] ?? 0)) / 2;
  return [middle(0), middle(1), clearance];
}

// `reach`: the longest way between two waypoints, for machines on which a straight line of the
// tip is none of their carriages; null: any.
export function trackOf(transcript: string, start: Point, reach: number | null): Track {
  const rows = transcript.split("\n").filter((row) => /^[<>] ?/.test(row));
  const lines: Line[] = rows.map((row) => ({ text: row.slice(2), isSent: row.startsWith(">"), step: 0, mark: null }));
  const sent = lines.flatMap((line, i) => (line.isSent ? [i] : []));
  const answersOf = (k: number) => lines.slice(sent[k]! + 1, sent[k + 1] ?? lines.length).map((line) => line.text);
  const reader = new Reader(start, reach ?? Infinity);
  const steps = sent.map((line, k): Step => {
    const text = lines[line]!.text;
    const from = reader.time;
    const follows = sent[k + 1] !== undefined && /^M114\b/i.test(lines[sent[k + 1]!]!.text) ? answersOf(k + 1) : null;
    const touch = reader.take(text, answersOf(k), follows);
    reader.close(from);
    const mark = markOf(text, touch);
    for (let i = line; i < (sent[k + 1] ?? lines.length); i++) lines[i]!.step = k;
    lines[line]!.mark = mark;
    return { line, text, mark, end: reader.time, last: reader.points.length - 1, touch };
  });
  return { lines, steps, points: reader.points, times: reader.times };
}

// The last index whose value is not above `value`; values ascend.
export function before(count: number, valueOf: (i: number) => number, value: number): number {
  let [low, high] = [0, count - 1];
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (valueOf(middle) <= value) low = middle;
    else high = middle - 1;
  }
  return Math.max(0, low);
}

export const stepAt = (track: Track, time: number): number => {
  const steps = track.steps;
  const i = before(steps.length, (k) => steps[k]!.end, time);
  return steps[i] && steps[i].end < time && i + 1 < steps.length ? i + 1 : i;
};
