import { Notice } from "../ui/parts";
import type { Axis, Bench, Entries } from "./model";
import type { BenchHold } from "./use_bench";

const numberOf = (text: string) => (text.trim() === "" ? NaN : Number(text.replace(",", ".")));

function ManualRow({ axis, now, hold, entries }: { axis: Axis; now: number; hold: BenchHold; entries: Entries }) {
  const kept = entries.manual[axis] ?? { commanded: "100", measured: "" };
  const change = (part: Partial<typeof kept>) => hold.keep({ manual: { ...entries.manual, [axis]: { ...kept, ...part } } });
  const commanded = numberOf(kept.commanded);
  const measured = numberOf(kept.measured);
  const isGood = commanded > 0 && measured > 0;
  const proposed = now * (commanded / measured);
  const percent = (proposed / now - 1) * 100;
  const name = axis.toUpperCase();
  return (
    <div className="cal-manual">
      <div className="row">
        <label>{name}: commanded, mm
          <input inputMode="decimal" size={8} value={kept.commanded} onChange={(event) => change({ commanded: event.target.value })} />
        </label>
        <label>{name}: measured, mm
          <input inputMode="decimal" size={8} value={kept.measured} onChange={(event) => change({ measured: event.target.value })} />
        </label>
        <output className="cal-output" aria-label={`New steps/mm of ${name}`}>
          {isGood ? `new = ${now.toFixed(3)} × ${commanded} / ${measured} = ${proposed.toFixed(3)} steps/mm (${percent >= 0 ? "+" : "−"}${Math.abs(percent).toFixed(2)} %)`
            : kept.measured.trim() === "" ? "not known: enter what you measured" : "Enter two lengths above 0 mm."}
        </output>
      </div>
      {isGood && Math.abs(percent) > 5 ? (
        <Notice kind="warn"><p>More than 5 %. Check that both lengths are of the same move before you use this.</p></Notice>
      ) : null}
      {isGood ? <p>To set it yourself, send <code>M92 {name}{proposed.toFixed(3)}</code> and put it into config.g.</p> : null}
    </div>
  );
}

export function ManualEntry({ hold, bench }: { hold: BenchHold; bench: Bench }) {
  const { settings } = bench;
  return (
    <details className="cal-fold">
      <summary>I have measured by hand already: calculate only</summary>
      <p>Move by a known length, measure it with callipers, enter both. Start the move in its own direction, so that
        backlash is out of the way. This is kept as a note; it does not change the machine.</p>
      {settings ? hold.entries.axes.map((axis) => (
        <ManualRow key={axis} axis={axis} now={settings.steps_per_mm[axis]} hold={hold} entries={hold.entries} />
      )) : <p>The steps/mm in force are not known yet.</p>}
    </details>
  );
}
