import type { Candidate } from "./types";

const causes: Record<string, string> = {
  unknown: "A pattern without a known cause",
  backlash: "Backlash",
  backlash_worn: "Backlash, worn in one place",
  squareness: "Axes out of square",
  motors_swapped: "Motors swapped",
  gantry_sag: "The gantry sags",
  axis_twist: "The beam is twisted",
  bed_bowl: "The bed is a bowl or a dome",
  bed_cylinder: "The bed is bent",
  bed_twist: "The bed is twisted",
  missed_steps: "Lost steps",
  cyclic_lead: "Cyclic error of the screw",
  pitch_progressive: "Changing pitch of the screw",
  trigger_latency: "The trigger is noticed late",
  frame_growth: "The frame grows while warming up",
  windup_load: "The drive winds up under load",
  pivot_position: "A screw stands elsewhere than believed",
  homing_scatter: "Homing scatters",
  microstep: "Uneven microsteps",
  angular: "A carriage turns as it moves",
  straightness: "A rail is bowed",
};
const pairs: Record<string, string> = { C0Y: "X and Y", B0Z: "X and Z", A0Z: "Y and Z" };
const turns: Record<string, string> = { A: "X", B: "Y", C: "Z" };
const follows: Record<string, string> = {
  t: "time", load: "load", feed: "feed rate", theta: "direction of touch",
  dir_x: "side of approach in X", dir_y: "side of approach in Y", dir_z: "side of approach in Z",
  dir_a: "side of approach of tower A", dir_b: "side of approach of tower B", dir_c: "side of approach of tower C",
  motor_a: "position of tower A", motor_b: "position of tower B", motor_c: "position of tower C",
  since_rev: "way since the reversal", temp: "temperature",
  x: "position in X", y: "position in Y", z: "position in Z",
};

export const plain = (name: string) => name.replace(/_/g, " ");
export const first = (text: string) => text.charAt(0).toUpperCase() + text.slice(1);
export const causeWord = (cause: string) => causes[cause] ?? first(plain(cause));
export const followWord = (name: string) => follows[name] ?? first(plain(name));

export function axisWord(axis: string): string {
  if (!axis) return "";
  if (pairs[axis]) return pairs[axis];
  const code = /^E([ABCXYZ])([XYZ])$/.exec(axis);
  if (code) {
    const turn = turns[code[1]!];
    return turn ? `turning about ${turn} while moving along ${code[2]}` : `${code[1]} while moving along ${code[2]}`;
  }
  const motors = axis.match(/z\d/g);
  if (motors && motors.length > 1) return motors.map((one) => one.toUpperCase()).join(" and ");
  return axis.length <= 2 ? axis.toUpperCase() : plain(axis);
}

export function causeAndAxis(one: Pick<Candidate, "cause" | "axis">): string {
  const axis = axisWord(one.axis);
  return axis ? `${causeWord(one.cause)} (${axis})` : causeWord(one.cause);
}

const units: Record<string, string> = {
  um: "µm", mm: "mm", mrad: "mrad", urad: "µrad", ppm: "ppm", ms: "ms", s: "s", deg: "°", n: "N",
};

// "sag_um" is the quantity "sag" in µm.
export function quantityOf(name: string): { name: string; unit: string } {
  const cut = name.lastIndexOf("_");
  const unit = cut > 0 ? units[name.slice(cut + 1)] : undefined;
  if (name === "at_t_s") return { name: "At time", unit: "s" };
  const shift = /^d([xyz])_mm$/.exec(name);
  if (shift) return { name: `Off in ${shift[1]!.toUpperCase()}`, unit: "mm" };
  return unit ? { name: first(plain(name.slice(0, cut))), unit } : { name: first(plain(name)), unit: "" };
}

const placeWord = (what: string, along: string) => (along === "turn" ? `How “${what}” is turned` : `Where “${what}” lies in ${axisWord(along)}`);

// Baseline and blind quantities: "scale.x", "bed_plane.slope_x", "placement.bed.z".
export function baselineWord(name: string): string {
  const [what, ...rest] = name.split(".");
  const where = rest.map(axisWord).join(" ");
  switch (what) {
    case "scale": return `Scale${where ? ` of ${where}` : ""} (steps/mm)`;
    case "backlash": return `Backlash of ${where}`;
    case "probe_pretravel": return `Pre-travel of the probe, ${where}`;
    case "squareness": return `Squareness of ${where}`;
    case "bed_plane": return `Tilt of the bed, ${plain(rest.join(" ")).replace("slope", "along").toUpperCase().replace("ALONG", "along")}`;
    // "z_columns/z_columns_1": a campaign, and its setup of nearly that name.
    case "placement": return placeWord(plain(rest.slice(0, -1).join(" ").split("/").at(-1) ?? ""), rest[rest.length - 1] ?? "");
    default: return `${causeWord(what ?? name)}${where ? ` (${where})` : ""}`;
  }
}

// Units and signs as people write them; no codes of errors (EXY), and no word with an
// underscore but settings' names, nor a campaign's key for plans.
export const nice = (text: string) =>
  text.replace(/\(`\w+` in a plan, /g, "(").replace(/\b[a-z]+(?:_[a-z]+)+\b/g, (word) => (causes[word] ? plain(word) : word)).replace(/\+-/g, "±").replace(/(\d) um\b/g, "$1 µm").replace(/\bum rms/g, "µm rms").replace(/(\d) urad\b/g, "$1 µrad").replace(/ \((?:E[ABCXYZ][XYZ]|[ABC]0[XYZ])\)/g, "").replace(/ \(--[a-z]+\)/g, "");

// A size in the unit that reads best, with three digits.
export function size(um: number | null | undefined): string {
  if (um === null || um === undefined || !Number.isFinite(um)) return "not known";
  const big = Math.abs(um) >= 1000;
  return `${Number((big ? um / 1000 : um).toPrecision(3))} ${big ? "mm" : "µm"}`;
}

export const percent = (part: number) =>
  part > 0.995 ? "over 99 %" : part < 0.01 ? "under 1 %" : `${Math.round(part * 100)} %`;
