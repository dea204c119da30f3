import { useEffect, useState } from "react";
import { answered, api, problemOf, type Problem, type Schemas } from "../api/client";
import { Busy, Card, Notice } from "../ui/parts";

const controllers = [
  ["rrf", "RepRapFirmware"], ["klipper", "Klipper"], ["marlin", "Marlin"], ["linuxcnc", "LinuxCNC"],
] as const;
type Controller = (typeof controllers)[number][0];

function CopyButton({ text }: { text: string }) {
  const [done, setDone] = useState("");
  const copy = () => {
    const failed = () => setDone("Copying failed. Select the text and copy it by hand.");
    // Absent on pages that are neither https nor of this computer.
    if (!navigator.clipboard) { failed(); return; }
    navigator.clipboard.writeText(text).then(() => setDone("Copied."), failed);
  };
  return (
    <p className="row">
      <button type="button" onClick={copy}>Copy</button>
      <span role="status">{done}</span>
    </p>
  );
}

function WhyNot({ problem }: { problem: Problem }) {
  return (
    <Notice kind={problem.status === 422 ? "info" : "bad"}>
      <p><strong>No settings to paste:</strong> {problem.detail}.</p>
      {problem.errors?.map((fault, i) => (fault.hint ? <p key={i} className="hint">{fault.hint}</p> : null))}
    </Notice>
  );
}

export function Correction({ id }: { id: string }) {
  const [controller, setController] = useState<Controller | "">("");
  const [found, setFound] = useState<Schemas["Correction"] | null>(null);
  const [problem, setProblem] = useState<Problem | null>(null);
  useEffect(() => {
    setFound(null);
    setProblem(null);
    if (!controller) return;
    let current = true;
    answered(api.GET("/api/diagnoses/{id}/correction", { params: { path: { id }, query: { for: controller } } }))
      .then((one) => current && setFound(one), (error: unknown) => current && setProblem(problemOf(error)));
    return () => { current = false; };
  }, [id, controller]);
  return (
    <Card title="Settings to paste">
      <label>Your controller
        <select value={controller} onChange={(event) => setController(event.target.value as Controller | "")}>
          <option value="">choose</option>
          {controllers.map(([key, name]) => <option key={key} value={key}>{name}</option>)}
        </select>
      </label>
      {controller && !found && !problem ? <Busy text="Working out the settings" /> : null}
      {problem ? <WhyNot problem={problem} /> : null}
      {found?.files.map((file) => (
        <div key={file.name}>
          <h3>{file.name}</h3>
          <pre tabIndex={0} aria-label={`Settings, ${file.name}`}>{file.text}</pre>
          <CopyButton text={file.text} />
        </div>
      ))}
    </Card>
  );
}
