// Names of quantities and checks as people say them, with the unit that the name holds.
import { axisWord, causeWord, plain, quantityOf } from "../diagnose/words";

const quantities: Record<string, string> = {
  steps_per_mm: "Steps/mm", probe_pretravel: "Pre-travel of the probe", bed_tilt: "Tilt of the bed", tip_size: "Radius of the tip",
  trigger_latency: "Delay of the trigger", endstop: "Endstop", belt_pitch: "Pitch of the belt", missed_steps: "Lost steps",
  frame_growth: "Growth of the frame", pivot_position: "Place of the screw", rod_mismatch: "Length of the rod, off by",
  tower_lean: "Lean of the tower", tower_radius: "Radius of the tower", tower_angle: "Angle of the tower", tower_twist: "Twist of the tower",
  squareness: "Squareness", motors_swapped: "Motors exchanged",
};
const lasts: Record<string, string> = {
  slope_x_mrad: "slope along X", slope_y_mrad: "slope along Y", growth_um: "how much", tau_s: "time constant", at_t_s: "when",
};
const units: Record<string, string> = { "1/mm": "steps/mm", "1": "", um: "µm", deg: "°" };

export const unitWord = (unit: string) => units[unit] ?? unit;

// "bed_tilt.slope_x_mrad" -> "Tilt of the bed, slope along X".
export function quantityName(name: string): string {
  const [what = name, ...rest] = name.split(".");
  const last = rest.at(-1);
  const hasUnit = last !== undefined && last.includes("_");
  const where = (hasUnit ? rest.slice(0, -1) : rest).map(axisWord).join(", ");
  const part = hasUnit ? `, ${lasts[last] ?? quantityOf(last).name.toLowerCase()}` : "";
  return `${quantities[what] ?? causeWord(what)}${where ? ` of ${where}` : ""}${part}`;
}

const checks: Record<string, string> = {
  level_error: "How far off level the bed stands", position_error: "How far off the tip goes", height_error: "Error of the heights",
  height_drift: "Drift of the heights, root mean square", height_reversal: "Largest difference of height after moves down and up",
  xy_scale: "Scale in X and Y", said: "Deviation that the procedure itself states",
};
const statistics: Record<string, string> = { mean: "mean", rms: "root mean square", max: "largest", p95: "95 % are below" };
const endUnits: [string, string][] = [["um_per_mm", "µm/mm"], ["mm", "mm"], ["um", "µm"], ["mrad", "mrad"], ["deg", "°"], ["ms", "ms"], ["s", "s"]];

export interface CheckName { title: string; unit: string }

// "level_error_mm.mean" -> "How far off level the bed stands, mean" in mm.
export function checkName(name: string): CheckName {
  if (name === "outcome") return { title: "How the run ends", unit: "" };
  if (name === "message") return { title: "A sentence that says", unit: "" };
  const reads = /^(.*)\.(reads|identifiable)$/.exec(name);
  if (reads) {
    const unit = reads[1]!.startsWith("steps_per_mm") ? "steps/mm" : "mm";
    return reads[2] === "reads" ? { title: `${quantityName(reads[1]!)}, as set`, unit } : { title: `${quantityName(reads[1]!)}: whether it can be told`, unit: "" };
  }
  const [figure = name, statistic] = name.split(".");
  const [key, unit] = endUnits.find(([end]) => figure.endsWith(`_${end}`)) ?? ["", ""];
  const what = key ? figure.slice(0, -key.length - 1) : figure;
  const title = checks[what] ?? plain(what).replace(/^./, (letter) => letter.toUpperCase());
  return { title: statistic ? `${title}, ${statistics[statistic] ?? plain(statistic)}` : title, unit };
}

// "above 0.001, below 0.006" -> "above 0.001 mm, below 0.006 mm".
export const withUnit = (text: string, unit: string) =>
  (unit ? text.replace(/-?\d[\d.]*(e[+-]?\d+)?/g, (number) => `${number} ${unit}`) : text);
