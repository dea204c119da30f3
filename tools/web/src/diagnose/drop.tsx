import { useEffect, useRef, useState } from "react";
import { examples } from "./examples";

const pasted = (text: string) => new File([text], "pasted.txt", { type: "text/plain" });

function Paste({ onFiles }: { onFiles: (files: File[]) => void }) {
  const [text, setText] = useState("");
  return (
    <details>
      <summary>Paste text instead</summary>
      <label className="wide">
        Log or table
        <textarea rows={6} value={text} onChange={(event) => setText(event.target.value)}
                  placeholder="commanded mm, measured mm" />
      </label>
      <p><button type="button" disabled={!text.trim()} onClick={() => onFiles([pasted(text)])}>Diagnose this text</button></p>
    </details>
  );
}

// Behind a tunnel or a proxy the server may be another computer than the one that shows the page.
function Private() {
  const here = /^(localhost|127\.|\[::1\])/.test(location.hostname);
  return here
    ? <p className="hint"><strong>Nothing leaves this computer.</strong> Only the caltwin program running here reads the files.</p>
    : <p className="hint"><strong>The files go to {location.hostname} only,</strong> where caltwin runs. Nothing goes further.</p>;
}

// A file dropped beside the zone would otherwise replace the page.
function useDrop(onFiles: (files: File[]) => void): boolean {
  const [over, setOver] = useState(false);
  const current = useRef(onFiles);
  current.current = onFiles;
  useEffect(() => {
    const drag = (event: DragEvent) => {
      if (!event.dataTransfer?.types.includes("Files")) return;
      event.preventDefault();
      setOver(event.type === "dragover");
      const files = [...event.dataTransfer.files];
      if (event.type === "drop" && files.length > 0) current.current(files);
    };
    const left = (event: DragEvent) => { if (!event.relatedTarget) setOver(false); };
    addEventListener("dragover", drag);
    addEventListener("drop", drag);
    addEventListener("dragleave", left);
    return () => {
      removeEventListener("dragover", drag);
      removeEventListener("drop", drag);
      removeEventListener("dragleave", left);
    };
  }, []);
  return over;
}

function Zone({ onFiles }: { onFiles: (files: File[]) => void }) {
  const over = useDrop(onFiles);
  const chooser = useRef<HTMLInputElement>(null);
  return (
    <div className={`drop${over ? " over" : ""}`}>
      <p className="drop-lead">{over ? "Let go to read the files" : "Drop measured files here"}</p>
      <p>
        <button type="button" onClick={() => chooser.current?.click()}>Choose files</button>
      </p>
      <input ref={chooser} type="file" multiple hidden aria-label="Measured files"
             onChange={(event) => {
               const files = [...(event.target.files ?? [])];
               event.target.value = "";
               if (files.length > 0) onFiles(files);
             }} />
      <p className="hint">
        Logs of Klipper, Marlin, RepRapFirmware and grbl, height maps, tables (CSV) of positions or sizes.
        A machine file may come along.
      </p>
      <Private />
    </div>
  );
}

// Text or files pasted anywhere but into a field.
function usePaste(onFiles: (files: File[]) => void) {
  const current = useRef(onFiles);
  current.current = onFiles;
  useEffect(() => {
    const paste = (event: ClipboardEvent) => {
      if (event.target instanceof Element && event.target.closest("input, textarea, select")) return;
      const files = [...(event.clipboardData?.files ?? [])];
      const text = event.clipboardData?.getData("text/plain") ?? "";
      if (files.length > 0) current.current(files);
      else if (text.trim()) current.current([pasted(text)]);
    };
    addEventListener("paste", paste);
    return () => removeEventListener("paste", paste);
  }, []);
}

export function Drop({ onFiles }: { onFiles: (files: File[]) => void }) {
  usePaste(onFiles);
  return (
    <section className="card" aria-labelledby="drop-title">
      <div className="card-head"><h2 id="drop-title">Your measurements</h2></div>
      <Zone onFiles={onFiles} />
      <div className="examples">
        <span className="hint">No file at hand? Try an example:</span>
        {examples.map((one) => (
          <button key={one.name} type="button" className="quiet" title={one.about}
                  onClick={() => onFiles([one.file()])}>{one.name}</button>
        ))}
      </div>
      <Paste onFiles={onFiles} />
    </section>
  );
}
