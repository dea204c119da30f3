// What the touches tell of the bed's shape beyond its tilt, and what they cannot.
import { plain, touchesOf, type BedTilt } from "./maths";

export interface Flatness { kind: "good" | "warn" | "bad" | "info"; title: string; text: string; todo: string }

const good_mm = 0.02;
const bent_mm = 0.1;

// Lines of touches across one direction: those closer than a millimetre are one.
function linesAcross(along: number[]): number {
  const sorted = [...along].sort((a, b) => a - b);
  return sorted.filter((mm, i) => i === 0 || mm - sorted[i - 1]! > 1).length;
}

// Directions along which there are but two lines of touches: a bend along these is not seen.
function blindOf(bed: BedTilt): string[] {
  const points = touchesOf(bed);
  const lines = { X: points.map((point) => point.x), Y: points.map((point) => point.y) };
  return Object.entries(lines).filter(([, along]) => linesAcross(along) < 3).map(([name]) => name);
}

const um = (mm: number) => `${plain(mm * 1000, 1)} µm`;

// Four heights less the three of a plane leave one figure: the twist.
function ofFour(bed: BedTilt): Flatness {
  const residual = bed.residual_mm;
  const title = `Twist: the touches lie ${um(residual)} off a plane. Bowl: not known`;
  const todo = "A bowl, a dome or a saddle along X and Y moves four corners alike, so here it looks flat. To see it, touch the centre too: measure a 3×3 grid.";
  const text = residual <= good_mm ? `Four touches tell the tilt and the twist, no more. The twist is small (good: ${good_mm} mm or less).`
    : `Four touches tell the tilt and the twist, no more. The bed is twisted, or one touch is off: four touches cannot tell which. Screws take the tilt away, not the twist.`;
  return { kind: residual <= good_mm ? "info" : residual <= bent_mm ? "warn" : "bad", title, text, todo };
}

function ofMany(bed: BedTilt, blind: string[]): Flatness {
  const residual = bed.residual_mm;
  const title = `How flat: ${um(residual)} off a plane`;
  const todo = blind.length > 0 ? `There are only two lines of touches along ${blind[0]}, so a bend along ${blind[0]} is not known. Measure a 3×3 grid to see it.` : "";
  if (residual > bent_mm) {
    return { kind: "bad", title, todo, text: `The bed is not a plane, or the probe misses (good: ${good_mm} mm or less). Screws cannot take this away: look at the bed and the probe first.` };
  }
  if (residual > good_mm) {
    return { kind: "warn", title, todo, text: `The bed is a little bent, or the probe scatters (good: ${good_mm} mm or less). Screws level it; a mesh takes the rest.` };
  }
  if (blind.length > 0) return { kind: "info", title, todo, text: `What these touches can show is flat (good: ${good_mm} mm or less).` };
  return { kind: "good", title, todo, text: `The bed is flat (good: ${good_mm} mm or less). Screws alone can level it.` };
}

export function flatnessOf(bed: BedTilt): Flatness {
  if (bed.measured_points < 4) {
    return { kind: "info", title: "How flat: not known", text: "Three points fit any plane.", todo: "Measure a 3×3 grid to see how flat the bed is." };
  }
  const blind = blindOf(bed);
  return bed.measured_points === 4 || blind.length === 2 ? ofFour(bed) : ofMany(bed, blind);
}
