import { useEffect, useMemo, useState } from "react";
import { answered, api, problemOf, type Problem, type Schemas } from "../api/client";
import { Busy, ProblemNotice } from "../ui/parts";

export type Scenario = Schemas["Scenarios"]["scenarios"][number];

const kinds: Record<string, string> = {
  cartesian: "Routers and mills",
  corexy: "CoreXY printers",
  delta: "Delta printers",
  triple_z: "Printers with three Z screws",
  motor_stage: "Motors on a bench (no tip to follow)",
  z_station: "Z probe stations (no tip to follow)",
};

export function useScenarios() {
  const [scenarios, setScenarios] = useState<Scenario[] | null>(null);
  const [problem, setProblem] = useState<Problem | null>(null);
  const load = () => {
    setProblem(null);
    answered(api.GET("/api/scenarios")).then((came) => setScenarios(came.scenarios), (fault: unknown) => setProblem(problemOf(fault)));
  };
  useEffect(load, []);
  return { scenarios, problem, load };
}

const fits = (scenario: Scenario, words: string[]) => {
  const text = `${scenario.name} ${scenario.name.replaceAll("_", " ")} ${scenario.about} ${scenario.machine} ${kinds[scenario.kinematics] ?? ""}`.toLowerCase();
  return words.every((word) => text.includes(word));
};

// For somebody who never saw one: each shows something else.
const good = [
  { name: "next_cluster_backlash_corrected", about: "A router: a touch probe finds lost motion" },
  { name: "tz_levels_in_one_round", about: "A printer: its three screws level a tilted bed" },
  { name: "delta_joint_recovers", about: "A delta printer: 37 touches find its geometry" },
];

function StartHere({ scenarios, onChoose }: { scenarios: Scenario[]; onChoose: (name: string) => void }) {
  const there = good.filter((one) => scenarios.some((scenario) => scenario.name === one.name));
  return (
    <div>
      <p className="hint">A scenario is a machine with known hidden errors and a procedure that should find them. Choose one, run it, and play back what it did.</p>
      <h3>New here? Start with one of these</h3>
      <ul className="mac-start">
        {there.map((one) => <li key={one.name}><button type="button" className="quiet" onClick={() => onChoose(one.name)}>{one.about}</button></li>)}
      </ul>
    </div>
  );
}

export function Choose({ all, chosen, onChoose, isBusy }: {
  all: ReturnType<typeof useScenarios>;
  chosen: Scenario | null;
  onChoose: (name: string) => void;
  isBusy: boolean;
}) {
  const [sought, setSought] = useState("");
  const { scenarios, problem, load } = all;
  const found = useMemo(() => {
    const words = sought.toLowerCase().split(/\s+/).filter(Boolean);
    return (scenarios ?? []).filter((one) => fits(one, words));
  }, [scenarios, sought]);
  if (problem) return <><ProblemNotice problem={problem} /><button type="button" onClick={load}>Try again</button></>;
  if (!scenarios) return <Busy text="Asking for the scenarios" />;
  const groups = Object.entries(kinds).map(([kind, title]) => ({ title, members: found.filter((one) => one.kinematics === kind) }));
  return (
    <div className="mac-choose">
      {chosen ? null : <StartHere scenarios={scenarios} onChoose={onChoose} />}
      <label>Search
        <input type="search" value={sought} placeholder="backlash, tilt, delta…" onChange={(event) => setSought(event.target.value)} />
      </label>
      <p className="hint mac-count" role="status">{found.length === scenarios.length ? `${found.length} scenarios` : `${found.length} of ${scenarios.length} scenarios`}</p>
      <div>
        <label htmlFor="scenario">All scenarios</label>
        <select id="scenario" size={8} value={chosen?.name ?? ""} disabled={isBusy} onChange={(event) => onChoose(event.target.value)}>
          {chosen && !found.includes(chosen) ? <option value={chosen.name}>{chosen.about}</option> : null}
          {groups.filter((group) => group.members.length > 0).map((group) => (
            <optgroup key={group.title} label={group.title}>
              {group.members.map((one) => <option key={one.name} value={one.name}>{one.about}</option>)}
            </optgroup>
          ))}
        </select>
      </div>
      {found.length === 0 ? <p>No scenario has these words. Try fewer.</p> : null}
      {chosen ? (
        <p className="mac-chosen"><strong>{chosen.about}</strong>
          <br /><span className="hint">{chosen.name} on {chosen.machine}</span></p>
      ) : null}
    </div>
  );
}
