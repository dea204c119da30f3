// The answer in one sentence, as the server's summary has it: report and page say the same.
import type { Diagnosis } from "./types";
import { nice } from "./words";

export type Kind = "good" | "warn" | "info";

const kinds: Record<string, Kind> = { nothing: "good", too_few: "info" };

export const kindOf = (one: Diagnosis): Kind => kinds[one.summary.answer] ?? "warn";

// The first sentence, and what follows it.
export function headOf(one: Diagnosis): { head: string; rest: string } {
  const whole = nice(one.summary.sentence);
  const end = /[.!?] (?=[A-Z])/.exec(whole);
  return end ? { head: whole.slice(0, end.index + 1), rest: whole.slice(end.index + 2) } : { head: whole, rest: "" };
}
