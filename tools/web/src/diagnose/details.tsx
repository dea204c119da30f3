import { Card, withSd } from "../ui/parts";
import type { Diagnosis, Quantity } from "./types";
import { Scroll } from "./scroll";
import { baselineWord, causeWord, first, nice, plain } from "./words";

const campaigns: Record<string, string> = {
  abbe: "one laser line at two places of another axis (called “abbe”)",
  plate_turned_90: "the same plate again, turned by 90°",
  ballbar: "circles in both senses with a ball-bar",
};

// "scale.x" is told where a fact has the figure, if only from one place and its zero.
function isTold(one: Diagnosis, what: string): boolean {
  const [quantity = "", axis] = what.split(".");
  const fact = { scale: "scale", backlash: "reversal" }[quantity];
  return (one.facts ?? []).some((each) => each.fact === fact && each.axis === axis);
}

export function NextSteps({ one }: { one: Diagnosis }) {
  const next = one.next_measurement ?? [];
  const unknown = (one.not_determined ?? []).filter((part) => !isTold(one, part.what));
  const plan = one.next_campaign;
  if (next.length === 0 && unknown.length === 0 && !plan) return null;
  return (
    <Card title="What to measure next">
      {next.map((step) => <p key={step.says}>{first(nice(step.says))}.</p>)}
      {plan ? (
        <p>Then: {campaigns[plan.kind] ?? plain(plan.kind)}, about {Math.max(1, Math.round(plan.minutes))} minutes.
          {plan.separates.length > 1 ? ` It tells apart: ${plan.separates.map((cause) => causeWord(cause).toLowerCase()).join("; ")}.` : ""}</p>
      ) : null}
      {unknown.length > 0 ? (
        <>
          <h3>Not known from these readings</h3>
          <ul>{unknown.map((part) => <li key={part.what + part.says}>{nice(part.says)}</li>)}</ul>
        </>
      ) : null}
    </Card>
  );
}

function Rows({ quantities }: { quantities: Quantity[] }) {
  return (
    <Scroll label="Plain settings"><table>
      <thead><tr><th>Quantity</th><th className="number">Off by (real minus set)</th></tr></thead>
      <tbody>{quantities.map((one) => (
        <tr key={one.name}>
          <td>{baselineWord(one.name)}</td>
          <td className="number">{one.determined ? withSd(one.value, one.sd, one.unit, one.unit === "ppm" ? 0 : 3) : "not known"}</td>
        </tr>))}
      </tbody>
    </table></Scroll>
  );
}

// A figure may be told by itself where it cannot be told from all others at once.
function NoneKnown({ one }: { one: Diagnosis }) {
  const told = (one.facts ?? []).filter((fact) => ["reversal", "scale", "plane", "squareness"].includes(fact.fact));
  if (told.length === 0) return <p>These readings determine none of them.</p>;
  return (
    <>
      <p>Fitted all at once, these readings settle none of them: one could stand in for another. Each looked at by itself, they say:</p>
      <ul>{told.map((fact) => <li key={fact.says}>{nice(fact.says)}.</li>)}</ul>
    </>
  );
}

export function Baseline({ one }: { one: Diagnosis }) {
  const all = one.baseline ?? [];
  if (all.length === 0) return null;
  const known = all.filter((part) => part.determined);
  const blind = all.filter((part) => !part.determined);
  return (
    <Card title="Plain settings, as measured">
      <p className="hint">These are always fitted first: scale, backlash, where things lie. ± is one standard deviation.</p>
      {known.some((part) => part.sd === null) ? <p className="hint">Without “±”: how sure the number is, is not known.</p> : null}
      {known.length > 0 ? <Rows quantities={known} /> : <NoneKnown one={one} />}
      {blind.length > 0 ? <details><summary>Not known from these readings ({blind.length})</summary><Rows quantities={blind} /></details> : null}
    </Card>
  );
}
