import { useState } from "react";
import { answered, api, problemOf, type Problem, type Schemas } from "../api/client";
import { Busy, Card, Notice, ProblemNotice } from "../ui/parts";

type Camera = Schemas["Intrinsics"];
type Key = "fx" | "fy" | "cx" | "cy" | "k1" | "k2" | "p1" | "p2" | "baseline_mm";

const fields: { key: Key; name: string; needed: boolean }[] = [
  { key: "fx", name: "fx, focal length, pixels", needed: true },
  { key: "fy", name: "fy, focal length, pixels", needed: true },
  { key: "cx", name: "cx, middle of the picture, pixels", needed: true },
  { key: "cy", name: "cy, middle of the picture, pixels", needed: true },
  { key: "k1", name: "k1, radial distortion", needed: false },
  { key: "k2", name: "k2, radial distortion", needed: false },
  { key: "p1", name: "p1, tangential distortion", needed: false },
  { key: "p2", name: "p2, tangential distortion", needed: false },
  { key: "baseline_mm", name: "Distance of two cameras, mm (empty: one camera)", needed: false },
];

function textOf(camera: Camera): Record<Key, string> {
  const text = (key: Key) => (camera[key] === undefined ? "" : String(camera[key]));
  return Object.fromEntries(fields.map(({ key }) => [key, text(key)])) as Record<Key, string>;
}

function bodyOf(text: Record<Key, string>): { camera: Camera; missing: string[] } {
  const camera: Camera = { fx: 0, fy: 0, cx: 0, cy: 0 };
  const missing: string[] = [];
  for (const { key, name, needed } of fields) {
    const value = text[key].trim();
    if (value === "" && !needed) continue;
    if (value === "" || !Number.isFinite(Number(value))) missing.push(name);
    else camera[key] = Number(value);
  }
  return { camera, missing };
}

export function CameraCard() {
  const [text, setText] = useState<Record<Key, string> | null>(null);
  const [source, setSource] = useState("");
  const [problem, setProblem] = useState<Problem | null>(null);
  const [note, setNote] = useState<{ kind: "good" | "bad"; text: string } | null>(null);
  const take = (camera: Camera) => {
    setText(textOf(camera));
    setSource(camera.source ?? "");
  };
  const go = async (asked: Promise<Camera>, said: string) => {
    setProblem(null);
    setNote(null);
    try {
      take(await asked);
      if (said) setNote({ kind: "good", text: said });
    } catch (error) {
      setProblem(problemOf(error));
    }
  };
  const load = () => void go(answered(api.GET("/api/calibration/intrinsics")), "");
  const save = (event: React.FormEvent) => {
    event.preventDefault();
    const { camera, missing } = bodyOf(text!);
    if (missing.length > 0) return setNote({ kind: "bad", text: `Write a number: ${missing.join("; ")}.` });
    void go(answered(api.POST("/api/calibration/intrinsics", { body: camera })), "Stored.");
  };
  return (
    <Card title="Camera (optional)">
      <details onToggle={(event) => event.currentTarget.open && !text && load()}>
        <summary>Numbers of the camera that looks at the bed</summary>
        <p>Only needed by other software that reads them from here; levelling does not use them. They come from a calibration of the camera, as OpenCV does it.</p>
        {source === "drawn" ? <Notice kind="info"><p>Nobody has stored any yet. These are examples, not measured.</p></Notice> : null}
        {!text && !problem ? <Busy text="Loading" /> : null}
        {text ? (
          <form onSubmit={save} noValidate>
            <div className="bed-camera">
              {fields.map(({ key, name }) => (
                <label key={key}>{name}
                  <input inputMode="decimal" value={text[key]} onChange={(event) => setText({ ...text, [key]: event.target.value })} />
                </label>
              ))}
            </div>
            <button type="submit" className="quiet">Store</button>
          </form>
        ) : null}
        {note ? <Notice kind={note.kind}><p>{note.text}</p></Notice> : null}
        {problem ? <ProblemNotice problem={problem} /> : null}
      </details>
    </Card>
  );
}
