import type { Schemas } from "../api/client";

export type BedTilt = Schemas["BedTilt"];
export type BedStatus = Schemas["BedStatus"];
export type Screws = Schemas["Screws"];
export type Plane = BedTilt["plane_equation"];
export type Touch = { x: number; y: number; z: number };

export const screwNames = ["z1", "z2", "z3"] as const;
export type ScrewName = (typeof screwNames)[number];

export const nowhere: Screws = { z1_mm: 0, z2_mm: 0, z3_mm: 0 };

export function offsetOf(screws: Screws, name: ScrewName): number {
  return screws[`${name}_mm`];
}

export function heightOf(plane: Plane, x: number, y: number): number {
  return plane.a * x + plane.b * y + plane.c;
}

export function touchesOf(bed: BedTilt): Touch[] {
  return (bed.points ?? []).map(([x = 0, y = 0, z = 0]) => ({ x, y, z }));
}

export function mostOffset(bed: BedTilt): number {
  return Math.max(...screwNames.map((name) => offsetOf(bed.z_offsets, name)));
}

export function isMoved(screws: Screws | null | undefined): boolean {
  return !!screws && screwNames.some((name) => Math.abs(offsetOf(screws, name)) >= 0.0005);
}

export function isRaised(status: BedStatus): boolean {
  return status.screws.some((screw) => Math.abs(screw.applied_mm) >= 0.0005);
}

// The notes say so where the rest is as small as the scatter.
export function isWithinNoise(bed: BedTilt): boolean {
  return bed.is_level === true;
}

export function isLevel(bed: BedTilt): boolean {
  return !isMoved(bed.z_offsets);
}

// "0.819", never "-0.000".
export function plain(value: number, digits = 3): string {
  const text = value.toFixed(digits);
  return Number(text) === 0 ? text.replace("-", "") : text;
}

export function signed(value: number, digits = 3): string {
  const text = plain(value, digits);
  return Number(text) > 0 ? `+${text}` : text.replace("-", "−");
}

// Slope along x and y: how sure, and together. The server states the sds; how the two go
// together follows from where the touches are.
function slopeCovariance(bed: BedTilt): { aa: number; ab: number; bb: number } | null {
  const points = touchesOf(bed);
  if (!bed.uncertainty || points.length < 4) return null;
  const middle = (of: (point: Touch) => number) =>
    points.reduce((sum, point) => sum + of(point), 0) / points.length;
  const x = middle((point) => point.x);
  const y = middle((point) => point.y);
  const xx = middle((point) => (point.x - x) ** 2);
  const yy = middle((point) => (point.y - y) ** 2);
  const xy = middle((point) => (point.x - x) * (point.y - y));
  const { a, b } = bed.uncertainty;
  return { aa: a * a, bb: b * b, ab: (-xy / Math.sqrt(xx * yy)) * a * b };
}

const degrees = 180 / Math.PI;

export function tiltOf(plane: Plane): number {
  return Math.atan(Math.hypot(plane.a, plane.b)) * degrees;
}

export function tiltSd(bed: BedTilt): number | null {
  const covariance = slopeCovariance(bed);
  if (!covariance) return null;
  const { a, b } = bed.plane_equation;
  const { aa, ab, bb } = covariance;
  const slope = Math.hypot(a, b);
  // Near level the direction of the tilt is not known: the larger of the two.
  if (slope * slope < 4 * Math.max(aa, bb)) return Math.sqrt(Math.max(aa, bb)) * degrees;
  return (Math.sqrt(a * a * aa + 2 * a * b * ab + b * b * bb) / slope) * degrees;
}

// Of the height of one screw over the highest; null where nothing tells it.
export function offsetSd(bed: BedTilt, screws: BedStatus["screws"], name: ScrewName): number | null {
  const covariance = slopeCovariance(bed);
  const own = screws.find((screw) => screw.name === name);
  const highest = highestScrew(bed, screws);
  if (!covariance || !own || !highest || own === highest) return null;
  const dx = own.at_mm[0]! - highest.at_mm[0]!;
  const dy = own.at_mm[1]! - highest.at_mm[1]!;
  return Math.sqrt(covariance.aa * dx * dx + 2 * covariance.ab * dx * dy + covariance.bb * dy * dy);
}

export function highestScrew(bed: BedTilt, screws: BedStatus["screws"]) {
  let best = screws[0];
  for (const screw of screws) {
    const height = heightOf(bed.plane_equation, screw.at_mm[0]!, screw.at_mm[1]!);
    if (best && height > heightOf(bed.plane_equation, best.at_mm[0]!, best.at_mm[1]!)) best = screw;
  }
  return best;
}

export type Read = { points: number[][]; fault: string | null };

// Lines "x y z" in mm, by commas, semicolons or blanks.
export function readPoints(text: string, least: number): Read {
  const points: number[][] = [];
  for (const [i, line] of text.split("\n").entries()) {
    if (!line.trim()) continue;
    // "20, 20, 0.15", "20;20;0,15": a comma between digits is a decimal one where others separate.
    const plain = /[;\t]|\d\s+\d/.test(line) ? line.replace(/(\d),(\d)/g, "$1.$2") : line;
    const words = plain.trim().split(/[\s,;]+/);
    const numbers = words.map(Number);
    if (words.length !== 3 || numbers.some((number) => !Number.isFinite(number))) {
      return { points, fault: `Line ${i + 1}: “${line.trim()}” is not three numbers. Write x, y and z in mm, as in “20, 20, 0.15”.` };
    }
    points.push(numbers);
  }
  if (points.length >= least) return { points, fault: null };
  const wanted = least === 1 ? "at least one point" : `at least ${least} points`;
  return { points, fault: `Write ${wanted}, one a line; ${points.length} so far.` };
}

// Exaggeration by which a range of heights shows as a quarter of the travel.
export function goodExaggeration(heights: number[], travel: number): number {
  const range = Math.max(...heights) - Math.min(...heights);
  if (!Number.isFinite(range) || range <= 0) return 100;
  return Math.min(500, Math.max(1, Math.round((0.25 * travel) / range)));
}

// Blue below, grey on, orange above the plane.
export function residualColour(residual: number | null, most: number): string {
  if (residual === null) return "#7a8694";
  const share = Math.max(-1, Math.min(1, residual / most));
  const to = share < 0 ? [33, 102, 200] : [224, 110, 10];
  const from = [150, 156, 164];
  const mixed = from.map((value, i) => Math.round(value + (to[i]! - value) * Math.abs(share)));
  return `rgb(${mixed.join(",")})`;
}

export function mostResidual(residuals: number[]): number {
  return Math.max(0.005, ...residuals.map(Math.abs));
}

export function when(bed: BedTilt): string {
  if (!bed.measured_at) return "not known when";
  return new Date(bed.measured_at).toLocaleString(undefined, { dateStyle: "medium", timeStyle: "medium" });
}
