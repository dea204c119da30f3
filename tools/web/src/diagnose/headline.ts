// A fact in a few words, for a headline: what it is, and how much.
import type { Fact } from "./types";
import { axisWord, nice, size } from "./words";

const longest = 90;

function ofReversal(fact: Fact): string | null {
  const gap_um = fact.gap_um;
  if (typeof gap_um !== "number") return null;
  const axis = axisWord(fact.axis);
  const mm = `${(Math.abs(gap_um) / 1000).toFixed(3)} mm`;
  return gap_um > 0 ? `${axis} loses ${mm} at each reversal: backlash` : `${axis} moves ${mm} too far at each reversal: backlash is corrected too much`;
}

function ofScale(fact: Fact): string | null {
  if (typeof fact.factor !== "number") return null;
  const off = fact.factor - 1;
  const share = Math.abs(off) >= 0.0005 ? `${Number((100 * Math.abs(off)).toPrecision(2))} %` : `${Math.round(1e6 * Math.abs(off))} ppm`;
  return `${axisWord(fact.axis)} moves ${share} too ${off > 0 ? "far" : "short"}: its steps/mm are off`;
}

const ofForm = (fact: Fact) => (typeof fact.peak_to_peak_um === "number"
  ? `The surface is uneven by ${size(Number(fact.peak_to_peak_um.toPrecision(2)))} from lowest to highest` : null);

const own: Record<string, (fact: Fact) => string | null> = { reversal: ofReversal, scale: ofScale, form: ofForm };

// What a sentence states before it explains; null where that is long.
function clauseOf(says: string): string | null {
  const clause = nice(says).split(/: |; |\. | \(|, where |, which /)[0] ?? "";
  return clause.length > 0 && clause.length <= longest ? clause.replace(/[.,]$/, "") : null;
}

const headOf = (fact: Fact) => own[fact.fact]?.(fact) ?? clauseOf(fact.says);

// The first that can be said shortly; how many more there are.
export function headline(facts: Fact[]): string | null {
  const [first, ...rest] = facts;
  const head = first ? headOf(first) : null;
  if (!head) return null;
  return rest.length > 0 ? `${head}, and ${rest.length} more` : head;
}
