import { headline } from "./headline";
import type { Diagnosis, Fact, Finding } from "./types";
import { causeAndAxis, first, percent, size } from "./words";

export interface Verdict { kind: "good" | "warn" | "info"; title: string; says: string; more: string[] }

const titles: Record<string, string> = {
  none: "No fault found", named: "Cause found", ambiguous: "More than one cause is possible",
  unknown: "Something is there, but no known cause fits",
};
const elsewhere: Record<string, string> = {
  settings: "Look at the settings first", firmware: "Look at the firmware first",
  file: "Look at the file first", slicer: "Look at the slicer first",
  work_offset: "The zero is off, not the axes", gauge: "Look at the gauge first",
  probe_mount: "Look at the probe and its mount first", reference_tool: "Look at the tool lengths first",
};
// Which fact tells of which cause: it comes first under the cause's name.
const ownFact: Record<string, string[]> = {
  levelling: ["motors_swapped", "pivot_position"], skew: ["squareness"], latency: ["trigger_latency"],
  homing_scatter: ["homing_scatter"], offset: ["axis_twist"],
};
const plainly = (says: string) =>
  says.replace("not even the baseline", "not even the plain settings (scale, backlash, where things lie)")
    .replace("Beyond the baseline these rows", "Beyond plain settings (scale, backlash, where things lie) these readings");
const lower = (text: string) => text.charAt(0).toLowerCase() + text.slice(1);
const dot = (says: string) => (/[.!?]$/.test(says) ? says : `${says}.`);
const same = (text: string, says: string) => text.includes(says.slice(0, 40));

// What a finding's sentence states, without the shares and gains that follow.
export const headOf = (sentence: string) => dot(sentence.replace(/: (over |under )?[\d.]+ % of what the model could not explain.*$/, "").replace(/; its shape fits no cause in the catalogue$/, ""));

function ofFindings(one: Diagnosis): string[] {
  const told = toldOf(one);
  return (one.findings ?? []).flatMap((finding, i) => {
    if (!told[i]) return [];
    const sentence = headOf(told[i].sentence);
    const rivals = rivalsOf(finding).filter((rival, at) => at === 0 || rival.probability > 0.05).slice(0, 2)
      .map((rival) => `${lower(causeAndAxis(rival))}: ${percent(rival.probability)}`);
    return rivals.length > 0 ? `${sentence} That is ${percent(finding.probability)} probable. It could also be: ${rivals.join("; or ")}.` : sentence;
  });
}

export const rivalsOf = (finding: Finding) =>
  finding.candidates.filter((one) => one.cause !== finding.cause || one.axis !== finding.axis);

// The first paragraph of the text, after "Verdict: WORD.", with the answers that it leaves out.
export function verdictOf(one: Diagnosis): Verdict {
  const paragraph = (one.text.split("\n\n")[0] ?? "").replace(/\n\s*/g, " ");
  const speaks = /^Verdict: (\w+: )?no cause of the catalogue, but the numbers speak\.\s*/;
  const says = plainly(dot(first(paragraph.replace(speaks, "").replace(/^Verdict: (none|named|ambiguous|unknown)[.,]\s*/, "").replace(/^but /, ""))));
  const findings = ofFindings(one);
  const other = one.not_the_machine;
  if (other) {
    const title = elsewhere[other.reason] ?? "It is not the machine";
    if (same(says, other.says)) return { kind: "warn", title, says, more: [] };
    const named = one.verdict === "named" ? (one.findings ?? []).map((finding) => dot(`Besides: ${causeAndAxis(finding)}`)) : [];
    const more = findings.length > 0 ? findings : named.length > 0 ? named : /cannot say what/.test(says) || few.test(says) ? [] : [says];
    return { kind: "warn", title, says: dot(other.says), more };
  }
  const stated = (one.facts ?? []).filter((fact) => fact.is_answer && fact.fact !== "outliers");
  if (speaks.test(paragraph)) return { kind: "warn", title: headline(stated) ?? numbersShow, says, more: [] };
  const causes = new Set((one.findings ?? []).map((finding) => finding.cause));
  const own = (fact: Fact) => (ownFact[fact.fact] ?? []).some((cause) => causes.has(cause));
  const facts = [...stated].sort((a, b) => Number(own(b)) - Number(own(a))).filter((fact) => !same(says, fact.says));
  const answers = facts.map((fact) => dot(fact.says));
  if (one.verdict === "none") return withoutFinding(says, facts, one.facts ?? []);
  const all = [...findings, ...answers];
  const named = one.verdict === "named" ? (one.findings ?? []).map(causeAndAxis).join("; ") : "";
  if (one.verdict === "unknown" && findings.length === 0 && answers.length > 0) {
    return { kind: "warn", title: headline(facts) ?? numbersShow, says: answers[0]!, more: answers.slice(1) };
  }
  const title = named ? `${titles.named}: ${lower(named)}` : openTitle(one);
  return { kind: "warn", title, says: all[0] ?? says, more: all.slice(1) };
}

// Where no cause is sure: between which two it is, or how much is unexplained.
function openTitle(one: Diagnosis): string {
  const [only, ...others] = one.findings ?? [];
  const title = titles[one.verdict] ?? "Answer";
  if (one.verdict === "ambiguous" && only && others.length === 0) {
    const [rival] = rivalsOf(only);
    if (rival) return `${title}: ${lower(causeAndAxis(only))}, or ${lower(causeAndAxis(rival))}`;
  }
  const isAxis = only && ["x", "y", "z"].includes(only.axis) && only.peak_um > 0;
  return one.verdict === "unknown" && isAxis ? `${only.axis.toUpperCase()} is off by up to ${size(Number(only.peak_um.toPrecision(2)))}, and no known cause fits` : title;
}

const few = /too few/;
const numbersShow = "What the numbers show";

function withoutFinding(says: string, facts: Fact[], all: Fact[]): Verdict {
  const answers = facts.map((fact) => dot(fact.says));
  if (answers.length > 0) return { kind: "warn", title: headline(facts) ?? "Plain settings are off", says: answers[0]!, more: [...answers.slice(1), says] };
  if (/^The machine drifted/.test(says)) return { kind: "warn", title: "The readings drift, and nothing measured says why", says, more: [] };
  const scarce = few.test(says);
  const [unsure] = all.filter((fact) => ["scale", "reversal"].includes(fact.fact) && fact.sigmas === null);
  if (scarce && unsure) return { kind: "info", title: "Too few readings to be sure", says: dot(unsure.says), more: ["These readings are too few to tell more."] };
  return { kind: scarce ? "info" : "good", title: scarce ? "Too few readings to tell" : titles.none!, says, more: [] };
}

export interface Told { sentence: string; lines: { key: string; says: string }[] }

// The paragraphs of the text that speak of the findings, in their order: between the
// verdict and what the numbers say by themselves.
export function toldOf(one: Diagnosis): Told[] {
  const told: Told[] = [];
  for (const paragraph of one.text.split("\n\n").slice(1)) {
    if (/^(What |The noise floor|The baseline|Baseline|Note:|Rows? |Not replayed|They )/.test(paragraph)) break;
    const [sentence, ...rest] = paragraph.split("\n");
    const lines = rest.map((line) => /^\s+([A-Z][\w' ]+?): (.*)$/.exec(line))
      .flatMap((match) => (match ? [{ key: match[1]!, says: match[2]! }] : []));
    if (sentence?.trim()) told.push({ sentence: sentence.trim(), lines });
  }
  return told.length === (one.findings ?? []).length ? told : [];
}

// "They would have shown changing pitch of the X screw from 5.7 um, ...": how small a fault
// these rows would have told.
export function wouldShow(one: Diagnosis): string[] {
  return one.text.split("\n").filter((line) => /^(They would have shown|They could not show|The baseline predicts)/.test(line));
}
