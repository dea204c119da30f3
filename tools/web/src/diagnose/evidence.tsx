import type { Evidence } from "./types";
import { Scroll } from "./scroll";
import { axisWord, causeWord, followWord } from "./words";

// Log odds in words; 4.6 are 100 to 1.
function strength(odds: number, hasFindings: boolean): { word: string; share: number } {
  if (odds > 4.6 && !hasFindings) return { word: "not confirmed", share: 25 };
  if (odds > 4.6) return { word: "strong", share: 55 };
  if (odds > 1) return { word: "weak", share: 25 };
  if (odds > -1) return { word: "undecided", share: 8 };
  return { word: "nothing", share: 0 };
}

// What was weighed before anything was accepted: without findings none of it passed their checks.
export function EvidenceMap({ map, hasFindings }: { map: Evidence[]; hasFindings: boolean }) {
  const rows = [...new Set(map.map((one) => one.channel))];
  const columns = [...new Set(map.map((one) => one.covariate))];
  return (
    <>
      <h3>Where the evidence lies</h3>
      <p className="hint">What is off (rows), and what it follows (columns). “Strong” is more than 100 to 1 for the cause named.
        {" "}{hasFindings ? "A strong cause lights up every cell that resembles it; only the best is meant." : "“Not confirmed” did not pass the checks of a finding."}</p>
      <Scroll label="Evidence map"><table className="evidence">
        <thead><tr><th scope="col">Readings of</th>{columns.map((one) => <th key={one} scope="col">{followWord(one)}</th>)}</tr></thead>
        <tbody>{rows.map((row) => (
          <tr key={row}>
            <th scope="row">{axisWord(row)}</th>
            {columns.map((column) => <Cell key={column} hasFindings={hasFindings} one={map.find((each) => each.channel === row && each.covariate === column)} />)}
          </tr>))}
        </tbody>
      </table></Scroll>
    </>
  );
}

function Cell({ one, hasFindings }: { one: Evidence | undefined; hasFindings: boolean }) {
  if (!one) return <td className="hint">–</td>;
  const { word, share } = strength(one.log_odds, hasFindings);
  return (
    <td style={{ background: `color-mix(in srgb, var(--accent) ${share * 0.5}%, var(--card))` }}>
      {word}{share > 8 ? <><br /><small>{causeWord(one.cause)}</small></> : null}
    </td>
  );
}
