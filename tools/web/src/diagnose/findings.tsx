import { useEffect, useState } from "react";
import { answered, api } from "../api/client";
import { Card, Figure } from "../ui/parts";
import type { Diagnosis, Finding } from "./types";
import { Shape } from "./shape";
import { Scroll } from "./scroll";
import { axisWord, causeAndAxis, causeWord, followWord, nice, percent, quantityOf, size } from "./words";

export function Findings({ one }: { one: Diagnosis }) {
  const findings = one.findings ?? [];
  return <>{findings.map((finding, i) => <FindingCard key={i} finding={finding} number={findings.length > 1 ? i + 1 : 0} />)}</>;
}

function FindingCard({ finding, number }: { finding: Finding; number: number }) {
  const axis = axisWord(finding.axis);
  const rivals = finding.candidates.filter((one) => one.cause !== finding.cause || one.axis !== finding.axis);
  return (
    <Card title={`${number ? `Finding ${number}: ` : "Finding: "}${causeWord(finding.cause)}`}
          aside={<span className="badge">{percent(finding.probability)} probable</span>}>
      <dl className="figures">
        {axis ? <div className="figure"><dt>Where</dt><dd>{axis}</dd></div> : null}
        {finding.parameters.map((one) => {
          const { name, unit } = quantityOf(one.name);
          return <Figure key={one.name} name={name} unit={unit} value={one.value} sd={one.sd} />;
        })}
        {finding.peak_um > 0 ? <div className="figure"><dt>Largest error here</dt><dd>{size(finding.peak_um)}</dd></div> : null}
        {finding.covariates.length > 0
          ? <div className="figure"><dt>Follows</dt><dd>{finding.covariates.map(followWord).join(", ")}</dd></div> : null}
        {finding.rows > 0 ? <div className="figure"><dt>Share of the unexplained</dt><dd>{percent(finding.share)}</dd></div> : null}
      </dl>
      {finding.parameters.some((one) => one.sd === null) ? <p className="hint">Without “±”: how sure the number is, is not known.</p> : null}
      <Rivals rivals={rivals} />
      {!finding.recommended ? <p><strong>Do not correct by this:</strong> readings that were kept aside get worse with it.</p> : null}
      {finding.knots ? <Shape knots={finding.knots} prefix={number ? `Finding ${number}: ` : ""} /> : null}
      {finding.parts && finding.parts.length > 0 ? <Parts finding={finding} /> : null}
      <Meaning cause={finding.cause} />
    </Card>
  );
}

function Rivals({ rivals }: { rivals: Finding["candidates"] }) {
  if (rivals.length === 0) return <p>No other known cause fits these rows.</p>;
  return (
    <>
      <h3>It could also be</h3>
      <ul>
        {rivals.map((one) => (
          <li key={one.cause + one.axis}>
            {causeAndAxis(one)}: {percent(one.probability)}
            {one.structural ? ". These rows cannot tell the two apart, however often they are repeated" : ""}
          </li>
        ))}
      </ul>
    </>
  );
}

function Parts({ finding }: { finding: Finding }) {
  return (
    <details>
      <summary>The shape in parts</summary>
      <Scroll label="The shape in parts"><table>
        <thead><tr><th>Part</th><th>Along</th><th className="number">Size</th></tr></thead>
        <tbody>{finding.parts!.map((part, i) => (
          <tr key={i}>
            <td>{part.name}{part.period ? `, every ${part.period.toPrecision(3)} mm` : ""}</td>
            <td>{part.along ? followWord(part.along) : "–"}</td>
            <td className="number">{part.size_um.toFixed(1)} ± {part.sd_um.toFixed(1)} µm</td>
          </tr>))}
        </tbody>
      </table></Scroll>
    </details>
  );
}

// From the text of `explain`: its first sentence, then the paragraphs of these headings.
const shownParts: [string, string][] = [["cause", "Usual cause"], ["effect", "What it does to parts"], ["action", "Remedy"], ["plot", "How it looks in a plot"]];

function explained(text: string): { about: string; parts: [string, string][] } {
  const lines = (text.split(/\n(?=\S)/)[0] ?? "").split("\n").slice(1);
  const start = lines.findIndex((line) => /^  (written |[a-z_]+ \[|[a-z ]+$)/.test(line));
  const about = lines.slice(0, start < 0 ? 1 : start).map((line) => line.trim()).join(" ");
  const parts = shownParts.flatMap(([key, title]): [string, string][] => {
    const at = lines.indexOf(`  ${key}`);
    if (at < 0) return [];
    const end = lines.findIndex((line, i) => i > at && !line.startsWith("    "));
    return [[title, lines.slice(at + 1, end < 0 ? undefined : end).map((line) => line.trim()).join(" ")]];
  });
  return { about, parts };
}

function Meaning({ cause }: { cause: string }) {
  const [text, setText] = useState("");
  useEffect(() => {
    answered(api.GET("/api/explain/{name}", { params: { path: { name: cause } } })).then((one) => setText(one.text), () => setText(""));
  }, [cause]);
  if (!text) return null;
  const { about, parts } = explained(text);
  return (
    <details>
      <summary>What “{causeWord(cause).toLowerCase()}” means</summary>
      <p>{about}</p>
      <dl>{parts.map(([title, says]) => <div key={title}><dt>{title}</dt><dd>{nice(says)}</dd></div>)}</dl>
    </details>
  );
}
