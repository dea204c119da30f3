import { useEffect, useState } from "react";
import { answered, api, problemOf, type Problem, type Schemas } from "../api/client";
import { Card, Figure, Notice, ProblemNotice } from "../ui/parts";
import { heightOf, readPoints, signed, type BedStatus, type BedTilt } from "./maths";

const target_mm = 0.1;

function defaultsOf(bed: BedTilt, status: BedStatus): string {
  const [width = 0, depth = 0] = status.travel_mm;
  const plane = bed.plane_now ?? bed.plane_equation;
  return [[0.2, 0.2], [0.8, 0.2], [0.5, 0.5], [0.2, 0.8], [0.8, 0.8]].map(([u = 0, v = 0]) => {
    const [x, y] = [Math.round(u * width), Math.round(v * depth)];
    return `${x}, ${y}, ${heightOf(plane, x, y).toFixed(3)}`;
  }).join("\n");
}

export function Validate({ bed, status }: { bed: BedTilt; status: BedStatus }) {
  const start = defaultsOf(bed, status);
  const [text, setText] = useState(start);
  const [isEdited, setIsEdited] = useState(false);
  const [result, setResult] = useState<Schemas["Validated"] | null>(null);
  const [problem, setProblem] = useState<Problem | null>(null);
  useEffect(() => {
    if (!isEdited) setText(start);
    setResult(null);
  }, [start]);
  const { points, fault } = readPoints(text, 1);
  const [asked, setAsked] = useState(false);
  const send = async () => {
    setAsked(true);
    setProblem(null);
    setResult(null);
    if (fault) return;
    try {
      setResult(await answered(api.POST("/api/calibration/validate", { body: { test_points: points } })));
    } catch (error) {
      setProblem(problemOf(error));
    }
  };
  return (
    <Card title="Check with another gauge (optional)">
      <p>Measure the bed in another way, say with a gauge at five places. Write the heights in: how far are they from the plane as it stands now? Good is a mean below {target_mm} mm. At the start the list has the plane's own heights.</p>
      <label className="bed-wide">Test points, one a line: x, y, z in mm
        <textarea rows={6} value={text} aria-invalid={asked && fault !== null}
                  onChange={(event) => { setText(event.target.value); setIsEdited(true); }} />
      </label>
      <div className="row">
        <button type="button" onClick={() => void send()}>Compare</button>
        <button type="button" className="quiet" disabled={!isEdited}
                onClick={() => { setText(start); setIsEdited(false); setResult(null); }}>Back to the plane's heights</button>
      </div>
      {asked && fault ? <Notice kind="bad"><p>{fault}</p></Notice> : null}
      {problem ? <ProblemNotice problem={problem} /> : null}
      {result ? <Verdict result={result} isEdited={isEdited} /> : null}
    </Card>
  );
}

function Verdict({ result, isEdited }: { result: Schemas["Validated"]; isEdited: boolean }) {
  const isGood = result.is_within_target;
  const mean = result.mean_error_mm.toFixed(3);
  return (
    <>
      <Notice kind={isGood ? "good" : "bad"}>
        <p><strong>{isGood
          ? `Within the target: the points are ${mean} mm from the plane on average; ${target_mm} mm are allowed.`
          : `Beyond the target: the points are ${mean} mm from the plane on average; ${target_mm} mm are allowed.`}</strong></p>
        {isEdited ? null : <p>These were the plane's own heights, so this only shows that the check works. Write in what you measured.</p>}
        {isGood && result.max_error_mm > target_mm ? <p>One point is further off than that; look at the largest.</p> : null}
      </Notice>
      <dl className="figures bed-figures">
        <Figure name={`Mean of ${result.num_points} points, without sign`} value={result.mean_error_mm} unit="mm" />
        <Figure name="Largest" value={result.max_error_mm} unit="mm" />
        <Figure name="Standard deviation" value={result.std_error_mm} unit="mm" />
        <div className="figure"><dt>Mean with sign (+: above)</dt><dd>{signed(result.mean_signed_error_mm)} mm</dd></div>
      </dl>
    </>
  );
}
