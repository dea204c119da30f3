// What POST /api/diagnose answers, as docs/data-format.md has it: the document of the
// REST interface leaves the parts of a diagnosis open.
import type { Schemas } from "../api/client";

export interface Candidate { cause: string; axis: string; probability: number; structural: boolean }
export interface Parameter { name: string; value: number; sd: number | null }
export interface Part { name: string; along: string; size_um: number; sd_um: number; period: number | null }
export interface Knots { channel: string; covariates: string[]; knots: number[][]; values_um: number[] }
export interface Finding {
  cause: string;
  axis: string;
  probability: number;
  candidates: Candidate[];
  parameters: Parameter[];
  share: number;
  covariates: string[];
  rows: number;
  peak_um: number;
  recommended: boolean;
  knots?: Knots;
  parts?: Part[];
}
export interface Fact { fact: string; axis: string; says: string; is_answer: boolean; rows: number[]; sigmas: number | null; steps_factor?: number | null; steps_factor_sd?: number | null; factor?: number | null; gap_um?: number | null; peak_to_peak_um?: number | null }
export interface LeftOut { rmse_before_um: number; rmse_after_um: number; rows: number }
export interface Gain {
  rmse_before_um: number | null;
  rmse_after_um: number | null;
  noise_floor_um: number | null;
  noise_floor_from: string;
  explained_fraction: number | null;
  held_out: boolean;
  runs_left_out?: LeftOut | null;
  positions_left_out?: LeftOut | null;
  ends_left_out?: LeftOut | null;
}
export interface Quantity { name: string; unit: string; value: number; sd: number | null; determined: boolean }
export interface Evidence { channel: string; covariate: string; log_odds: number; cause: string; axis: string }
export interface Fit {
  campaign: string;
  rows: number;
  replicate_dof: number;
  pure_error_um: number | null;
  before_um: number;
  after_um: number;
}
export interface Contrast { axis: string; sd_um: number; at_mm: number[]; before_um: number[]; after_um: number[] }
export interface Periodogram {
  axis: string;
  turn_mm: number;
  turn_of: string;
  noise_um: number;
  peaks: { period_mm: number; before_um: number; after_um: number }[];
}
export interface Flagged { row: number; cmd_mm: (number | null)[]; value_mm: number; left_um: number; sigmas: number; left_out: boolean }
export interface PlaceError { is_touch: boolean; cmd_mm: (number | null)[]; n: (number | null)[]; sense: number; rows: number; fitted_um: number }
export interface Show {
  evidence_map?: Evidence[];
  lack_of_fit?: Fit[];
  direction_contrast?: Contrast[];
  periodograms?: Periodogram[];
  flagged_rows?: Flagged[];
  places?: PlaceError[];
  places_of?: "findings" | "baseline";
}
export interface Summary {
  answer: "cause" | "figure" | "elsewhere" | "nothing" | "too_few";
  sentence: string;
  found: string[];
  cannot_tell: string[];
  to_do: string[];
}

export interface Diagnosis extends Omit<Schemas["Diagnosis"], "summary" | "findings" | "gain" | "facts"
  | "not_the_machine" | "show"> {
  summary: Summary;
  findings?: Finding[];
  gain?: Gain;
  facts?: Fact[];
  not_the_machine?: { reason: string; says: string } | null;
  baseline?: Quantity[];
  show?: Show | null;
}

export function diagnosesOf(answer: Schemas["Diagnoses"]): Diagnosis[] {
  const all = "diagnoses" in answer ? answer.diagnoses : [answer];
  return all as unknown as Diagnosis[];
}

// Whether the machine was read from the settings in the file itself.
export const hasOwnMachine = (one: Diagnosis) =>
  (one.remarks ?? []).some((remark) => remark.startsWith("the machine is that of the settings in the same file"));
