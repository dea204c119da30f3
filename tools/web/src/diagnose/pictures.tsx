import { Card } from "../ui/parts";
import { Curve } from "./curve";
import { EvidenceMap } from "./evidence";
import type { Contrast, Diagnosis, Fit, Periodogram } from "./types";
import { Scroll } from "./scroll";
import { axisWord, plain, size } from "./words";

export function Pictures({ one }: { one: Diagnosis }) {
  const show = one.show;
  const map = show?.evidence_map ?? [];
  const contrasts = show?.direction_contrast ?? [];
  const fits = show?.lack_of_fit ?? [];
  const periods = (show?.periodograms ?? []).filter((each) => each.peaks.length > 0);
  if (map.length + contrasts.length + fits.length + periods.length === 0) return null;
  return (
    <Card title="How it was found">
      {map.length > 0 ? <EvidenceMap map={map} hasFindings={(one.findings ?? []).length > 0} /> : null}
      {contrasts.map((each) => <details key={each.axis}><summary>Difference of the two directions, {axisWord(each.axis)}</summary><Both contrast={each} /></details>)}
      {fits.length > 0 ? <details><summary>Each group of readings, before and after</summary><Fits fits={fits} /></details> : null}
      {periods.map((each) => <details key={each.axis}><summary>Repeating patterns, {axisWord(each.axis)}</summary><Periods one={each} /></details>)}
    </Card>
  );
}

function Both({ contrast }: { contrast: Contrast }) {
  return (
    <Curve title={`What is left of the difference between the two directions of ${axisWord(contrast.axis)}, each known to ${size(contrast.sd_um)}`}
           x={contrast.at_mm} xLabel={`Position in ${axisWord(contrast.axis)}, mm`}
           series={[{ name: "Before, µm", values: contrast.before_um, dashed: true }, { name: "After, µm", values: contrast.after_um }]} />
  );
}

function Fits({ fits }: { fits: Fit[] }) {
  return (
    <Scroll label="Groups of readings"><table>
      <thead><tr><th>Group</th><th className="number">Rows</th><th className="number">Scatter of repeats</th>
        <th className="number">Left over, before</th><th className="number">after</th></tr></thead>
      <tbody>{fits.map((fit) => (
        <tr key={fit.campaign}><td>{plain(fit.campaign)}</td><td className="number">{fit.rows}</td>
          <td className="number">{fit.replicate_dof > 0 ? size(fit.pure_error_um) : "not known"}</td>
          <td className="number">{size(fit.before_um)}</td><td className="number">{size(fit.after_um)}</td></tr>))}
      </tbody>
    </table></Scroll>
  );
}

function Periods({ one }: { one: Periodogram }) {
  return (
    <>
      <p className="hint">One turn of the {one.turn_of} is {one.turn_mm} mm. Noise: {size(one.noise_um)}.</p>
      <Scroll label="Repeating patterns"><table>
        <thead><tr><th className="number">Repeats every</th><th className="number">Size before</th><th className="number">Size after</th></tr></thead>
        <tbody>{one.peaks.map((peak, i) => (
          <tr key={i}><td className="number">{Number(peak.period_mm.toPrecision(4))} mm</td>
            <td className="number">{size(peak.before_um)}</td><td className="number">{size(peak.after_um)}</td></tr>))}
        </tbody>
      </table></Scroll>
    </>
  );
}
