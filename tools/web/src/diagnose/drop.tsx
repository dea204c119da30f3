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

function Zone({ onFiles, busy }: { onFiles: (files: File[]) => void; busy: boolean }) {
  const [over, setOver] = useState(false);
  const chooser = useRef<HTMLInputElement>(null);
  const take = (list: FileList | null) => {
    if (list && list.length > 0) onFiles([...list]);
  };
  return (
    <div className={`drop${over ? " over" : ""}`}
         onDragOver={(event) => { event.preventDefault(); setOver(true); }}
         onDragLeave={() => setOver(false)}
         onDrop={(event) => { event.preventDefault(); setOver(false); take(event.dataTransfer.files); }}>
      <p className="drop-lead">Drop measured files here</p>
      <p>
        <button type="button" disabled={busy} onClick={() => chooser.current?.click()}>Choose files</button>
      </p>
      <input ref={chooser} type="file" multiple hidden aria-label="Measured files"
             onChange={(event) => { take(event.target.files); event.target.value = ""; }} />
      <p className="hint">
        Logs of Klipper, Marlin, RepRapFirmware and grbl, height maps, tables (CSV) of positions or sizes.
        A machine file may come along.
      </p>
      <p className="hint"><strong>Nothing leaves this computer.</strong> Only the caltwin program running here reads the files.</p>
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

export function Drop({ onFiles, busy }: { onFiles: (files: File[]) => void; busy: boolean }) {
  usePaste(onFiles);
  return (
    <section className="card" aria-labelledby="drop-title">
      <div className="card-head"><h2 id="drop-title">Your measurements</h2></div>
      <Zone onFiles={onFiles} busy={busy} />
      <div className="examples">
        <span className="hint">No file at hand? Try an example:</span>
        {examples.map((one) => (
          <button key={one.name} type="button" className="quiet" disabled={busy} title={one.about}
                  onClick={() => onFiles([one.file()])}>{one.name}</button>
        ))}
      </div>
      <Paste onFiles={onFiles} />
    </section>
  );
}
