import { useState } from "react";
import { CameraCard } from "../bed/camera";
import { History } from "../bed/history";
import { Answer, Results } from "../bed/results";
import { ScrewsCard } from "../bed/screws";
import { Setup } from "../bed/setup";
import { StatusLine, Troubles } from "../bed/status";
import { useBed, type Grid } from "../bed/use_bed";
import { Validate } from "../bed/validate";
import { BedView } from "../bed/view";
import { Busy, Card, Notice } from "../ui/parts";
import "../bed/bed.css";

export default function BedPage() {
  const bed = useBed();
  const [grid, setGrid] = useState<Grid>({ rows: 3, columns: 3, reference: 10 });
  const { status, current } = bed;
  const isMeasuring = bed.doing === "measure"
    || (bed.connection !== "lost" && bed.live !== null && !bed.live.ended);
  const hasNoBed = !status && bed.problem?.status === 404;
  return (
    <>
      <h1>Level the bed</h1>
      <Troubles bed={bed} problem={hasNoBed ? null : bed.problem} />
      {hasNoBed ? (
        <Notice kind="info">
          <p><strong>The machine served here has no bed on three screws.</strong></p>
          <p>Start <code>caltwin serve --http</code> without <code>--machine</code> for a practice printer, or with a printer that has three Z screws.</p>
        </Notice>
      ) : null}
      {bed.loading ? <Busy text="Asking the server about the printer" /> : null}
      {!status && !bed.loading && !hasNoBed ? <p><button type="button" onClick={() => void bed.reload()}>Try again</button></p> : null}
      {status ? (
        <>
          <p>For a printer whose bed stands on three screws, each with its own motor. Measure; the page lays a plane through the
            touches and says how far each screw must rise so that the bed is level. You see it before anything moves.</p>
          <StatusLine bed={bed} status={status} />
          {current ? <Answer bed={current} isMeasuring={isMeasuring} /> : null}
          <div className="bed-grid">
            <div>
              <Setup bed={bed} status={status} grid={grid} setGrid={setGrid} />
              {current ? <ScrewsCard bed={bed} status={status} found={current} grid={grid} /> : <NothingYet />}
              {current ? <Results bed={current} /> : null}
            </div>
            <div>
              <BedView status={status} bed={current} live={bed.live} />
              {current ? <Validate bed={current} status={status} /> : null}
            </div>
          </div>
          {bed.past.length > 0 ? <History past={bed.past} status={status} /> : null}
          <CameraCard />
        </>
      ) : null}
    </>
  );
}

function NothingYet() {
  return (
    <Card title="What comes next">
      <p>This bed was not measured yet. Choose “Measure”: the result says how far each of the three screws is to be raised.</p>
    </Card>
  );
}
