import { Card } from "../ui/parts";
import type { Answer } from "./ask";
import { headOf } from "./verdict";
import { plain } from "./words";

function describe(answer: Answer): string {
  const { machine, unit, axis, least, steps } = answer.assumed;
  return [machine && plain(machine), unit && `unit ${unit}`, axis && `axis ${axis.toUpperCase()}`, least && `from ${least} µm`, steps && `${steps} steps/mm`]
    .filter(Boolean).join(", ");
}

export function Recent({ answers, shown, onOpen }: {
  answers: Answer[];
  shown: Answer | null;
  onOpen: (answer: Answer) => void;
}) {
  if (answers.length === 0 || (answers.length === 1 && shown === answers[0])) return null;
  return (
    <Card title="Answers of this visit">
      <ul className="recent">
        {answers.map((one) => (
          <li key={one.key}>
            <button type="button" className="quiet" aria-current={one === shown ? "true" : undefined} onClick={() => onOpen(one)}>
              {one.files.map((file) => file.name).join(", ")}
            </button>
            <span className="hint">
              {one.at.toLocaleTimeString()} · {one.diagnoses.map((each) => headOf(each).head).join(" ")}
              {describe(one) ? ` · assumed: ${describe(one)}` : ""}
            </span>
          </li>
        ))}
      </ul>
    </Card>
  );
}
