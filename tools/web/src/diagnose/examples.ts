// Small files made in the page, so that one can see an answer before measuring anything.
// The same numbers each time: the scatter comes from a fixed sequence.
export interface Example { name: string; about: string; file: () => File }

function scatter(): () => number {
  let state = 12345;
  const next = () => {
    state = (state * 1103515245 + 12345) % 2147483648;
    return state / 2147483648;
  };
  return () => next() + next() + next() - 1.5;
}

function positions(name: string, error: (at: number, sense: number) => number): File {
  const noise = scatter();
  const lines = ["commanded X mm,direction,measured mm"];
  for (let round = 0; round < 3; round += 1) {
    for (const sense of [1, -1]) {
      for (let i = 0; i < 17; i += 1) {
        const at = 20 + 10 * (sense > 0 ? i : 16 - i);
        lines.push(`${at},${sense > 0 ? "+" : "-"},${(at + error(at, sense) + 0.002 * noise()).toFixed(4)}`);
      }
    }
  }
  return new File([`${lines.join("\n")}\n`], name, { type: "text/csv" });
}

function touches(name: string): File {
  const noise = scatter();
  const lines: string[] = [];
  for (let round = 0; round < 2; round += 1) {
    for (let y = 20; y <= 180; y += 40) {
      for (let x = 20; x <= 180; x += 40) {
        const sag = -0.09 * (1 - ((x - 100) / 80) ** 2);
        lines.push(`probe at ${x.toFixed(3)},${y.toFixed(3)} is z=${(-sag + 0.008 * noise()).toFixed(6)}`);
      }
    }
  }
  return new File([`${lines.join("\n")}\n`], name, { type: "text/plain" });
}

export const examples: Example[] = [
  { name: "Backlash", about: "a dial against X, from both sides",
    file: () => positions("example_backlash.csv", (_at, sense) => -0.03 * sense) },
  { name: "Wrong steps/mm", about: "X moves too far by 2 mm in a metre",
    file: () => positions("example_steps.csv", (at) => 0.002 * at) },
  { name: "Bent or sagging", about: "a printer's log of bed touches",
    file: () => touches("example_touches.log") },
];
