// What the fit says at the measured places, made ready to be drawn.
import type { Mark } from "../machine/errors";
import type { SceneData } from "../machine/data";
import type { Diagnosis, PlaceError } from "./types";

export type Triple = [number, number, number];
const letters = ["X", "Y", "Z"] as const;
const least_um = 0.05;

// Facts that plain settings make, where no finding does.
const ofSettings = ["reversal", "scale", "plane", "squareness"];

const isWhole = (place: PlaceError) => place.n.every((part) => part !== null) && place.cmd_mm.some((mm) => mm !== null);

export const placesOf = (one: Diagnosis) => (one.show?.places ?? []).filter(isWhole);

export const mostOf = (places: PlaceError[]) => Math.max(0, ...places.map((place) => Math.abs(place.fitted_um)));

// Drawn is what the answer states, and nothing where the fault is not the machine's.
export function isDrawable(one: Diagnosis): boolean {
  if (one.not_the_machine || mostOf(placesOf(one)) < least_um) return false;
  return one.show?.places_of === "findings" || (one.facts ?? []).some((fact) => fact.is_answer && ofSettings.includes(fact.fact));
}

// Letters of the coordinates that no row tells.
export const untold = (places: PlaceError[]) => letters.filter((_, k) => places.every((place) => place.cmd_mm[k] === null));

export const commanded = (places: PlaceError[], middle: Triple): Triple[] =>
  places.map((place) => place.cmd_mm.map((mm, k) => mm ?? middle[k]!) as Triple);

export const middleOf = (data: SceneData): Triple =>
  data.travel_mm.map(([from = 0, to = 0]) => (from + to) / 2) as Triple;

function spanOf(at: Triple[]): Triple {
  return [0, 1, 2].map((k) => Math.max(...at.map((one) => one[k]!)) - Math.min(...at.map((one) => one[k]!))) as Triple;
}

export const sizeOf = (at: Triple[]) => Math.max(1, Math.hypot(...spanOf(at)));

// Both senses along the line of the places itself would lie upon each other.
export const isBeside = (places: PlaceError[]) =>
  places.some((place) => !place.is_touch && place.sense < 0) && places.some((place) => !place.is_touch && place.sense > 0);

// Errors along the line of the places itself bend nothing. Then the distance of the places,
// by which an arrow should not exceed it; else null.
export function stepInLine(places: PlaceError[], at: Triple[]): number | null {
  const span = spanOf(at);
  const axis = span.findIndex((mm) => mm > 0);
  const isInLine = axis >= 0 && span.filter((mm) => mm > 0).length === 1 && places.every((place) => Math.abs(place.n[axis] ?? 0) > 0.99);
  if (!isInLine) return null;
  const sorted = [...new Set(at.map((one) => one[axis]!))].sort((a, b) => a - b);
  const steps = sorted.slice(1).map((mm, i) => mm - sorted[i]!).sort((a, b) => a - b);
  return steps[Math.floor(steps.length / 2)] ?? null;
}

export function marksOf(places: PlaceError[], at: (Triple | null)[]): Mark[] {
  const size = sizeOf(at.filter((one) => one !== null));
  const beside = isBeside(places);
  return places.flatMap((place, i) => {
    const here = at[i];
    if (!here) return [];
    const n = place.n as Triple;
    const shift = beside && place.sense < 0 ? size * 0.08 : 0;
    const across: Triple = Math.abs(n[1]) > Math.max(Math.abs(n[0]), Math.abs(n[2])) ? [1, 0, 0] : [0, -1, 0];
    return [{ at_mm: here.map((mm, k) => mm + shift * across[k]!) as Triple, n, um: place.fitted_um, sense: place.sense }];
  });
}

// Without a machine: a plate below the places, as large as they reach, and no more.
export function plainScene(at: Triple[]): SceneData {
  const span = spanOf(at);
  const size = sizeOf(at);
  const least = size * 0.02;
  const centre = [0, 1, 2].map((k) => Math.min(...at.map((one) => one[k]!)) + span[k]! / 2);
  const thick = size * 0.004;
  const low = Math.min(...at.map((one) => one[2]));
  return {
    machine: "measured places", moves: false, travel_mm: [[0, 0], [0, 0], [0, 0]], bodies: ["room"], poses: [[0, 0, 0, 1, 0, 0, 0]], meshes: [], rods: [],
    geoms: [{ body: 0, type: "box", size_mm: [Math.max(span[0] / 2, least) + least, Math.max(span[1] / 2, least * 2) + least, thick],
      pose: [centre[0]!, centre[1]!, low - thick, 1, 0, 0, 0], rgba: [0.72, 0.75, 0.79, 1], mesh: null }],
  };
}

// "X" or "" where errors are along more than one direction.
export function alongOf(places: PlaceError[]): string {
  const found = new Set(places.map((place) => place.n.findIndex((part) => Math.abs(part ?? 0) > 0.99)));
  return found.size === 1 ? letters[[...found][0]!] ?? "" : "";
}
