// Drives the page "Diagnose" against a fresh server (practice machines, --fidelity fast).
// Only files are read: the machine is never asked to move, so nothing is left running on it.
const table = (error) => {
  const lines = ["commanded X mm,direction,measured mm"];
  for (let round = 0; round < 3; round += 1) {
    for (const sense of [1, -1]) {
      for (let i = 0; i < 9; i += 1) {
        const at = 20 + 20 * (sense > 0 ? i : 8 - i);
        lines.push(`${at},${sense > 0 ? "+" : "-"},${(at + error(at, sense) + 0.001 * Math.sin(7 * i + 3 * round + sense)).toFixed(4)}`);
      }
    }
  }
  return lines.join("\n");
};
const file = (name, text) => ({ name, mimeType: "text/plain", buffer: Buffer.from(text) });
const heading = (page, name) => page.getByRole("heading", { name }).first();
const seen = (locator) => locator.waitFor({ timeout: 8000 }).then(() => true, () => false);

async function examples(page, check) {
  await page.getByRole("button", { name: "Backlash" }).click();
  check(await seen(heading(page, /^X loses 0\.0\d+ ± [\d.]+ mm at its reversals/)), "the example with backlash gets a verdict");
  await page.getByRole("button", { name: "Bent or sagging" }).click();
  check(await seen(heading(page, /^Finding/)), "the example of touches gets a finding");
  check(await seen(page.getByText(/probable/).first()), "the finding has a probability");
}

// The server's summary, and nothing of the page's own: the report has the same sentences.
async function sameAsSummary(page, base, check) {
  const asPage = (text) => text.replace(/\+-/g, "±").replace(/ um\b/g, " µm").replace(/\s+/g, " ");
  for (const path of ["tests/field/marks_stretch_in_mid_travel/marks.csv", "tests/field/two_free_corners_differ_by_a_millimetre/klippy_part.log"]) {
    const coming = page.waitForResponse((one) => one.url().endsWith("/api/diagnose") && one.ok());
    await page.getByLabel("Measured files").setInputFiles([`${check.root}/${path}`]);
    const { summary, id } = await (await coming).json();
    const verdict = page.locator(`section[aria-labelledby="verdict-${id}"] .notice`);
    await verdict.waitFor();
    check((await verdict.innerText()).replace(/\s+/g, " ") === asPage(summary.sentence), `the headline is the summary's sentence: ${summary.sentence.slice(0, 40)}...`);
    const items = await page.getByRole("region", { name: "What it means" }).getByRole("listitem").count();
    check(items === summary.found.length + summary.cannot_tell.length + summary.to_do.length, "the lists are the summary's");
    const report = (await (await page.request.get(`${base}/api/diagnoses/${id}/report`)).text()).replace(/\s+/g, " ");
    check(report.includes(asPage(summary.sentence).slice(0, 60)), "the report begins with the same sentence");
  }
}

async function settings(page, check) {
  await page.getByLabel("Measured files").setInputFiles([file("steps.csv", table((at) => 0.002 * at))]);
  await seen(page.getByText("steps.csv").first());
  await page.getByLabel("Steps/mm of X set now").fill("80");
  check(await seen(page.getByText(/Set 79\.8\d* ± [\d.]+ steps\/mm/)), "new steps/mm are worked out");
  await page.getByLabel("Your controller").selectOption({ label: "Marlin" });
  check(await seen(page.getByText("The line above is all there is to paste.")), "steps/mm that were typed need no machine");
  await page.getByLabel("Steps/mm of X set now").fill("");
  check(await seen(page.getByText("No settings to paste:")), "a correction that cannot be given says why");
  await page.getByRole("combobox", { name: "Machine" }).selectOption("gantry_router");
  check(await seen(page.getByRole("img", { name: "Picture of the gantry router" })), "the machine chosen is shown");
  await page.getByLabel("Your controller").selectOption({ label: "Marlin" });
  check(await seen(page.getByRole("button", { name: "Copy" })), "with a machine there are settings to copy");
  await page.getByRole("combobox", { name: "Machine" }).selectOption("");
}

// What was said of the machine: steps/mm go into the settings to paste; a .cfg describes it.
async function assumed(page, check) {
  await page.getByLabel("Measured files").setInputFiles([file("steps.csv", table((at) => 0.002 * at))]);
  await seen(heading(page, /^X moves 1\.002/));
  const steps = page.getByLabel("Steps/mm set now");
  await steps.fill("80");
  await steps.press("Enter");
  check(await seen(page.getByText(/Set 79\.8\d* ± [\d.]+ steps\/mm/)), "steps/mm that are assumed give the settings to paste");
  await page.getByLabel("Measured files").setInputFiles([`${check.root}/tests/data/imports/delta_super_racer.cfg`]);
  await seen(heading(page, /Two opposite corners/));
  check(await page.getByRole("combobox", { name: "Machine" }).locator("option:checked").innerText() === "as delta_super_racer.cfg says", "a machine that is read from a .cfg is not called none");
  const map = page.getByRole("region", { name: "How it was found" }).getByRole("group", { name: "Evidence map" });
  check(await map.isVisible(), "the evidence map is open");
}

// One table of two cannot be read: its columns are asked for, and it is answered.
async function columnsOfOne(page, check) {
  const rows = [10, 20, 30, 40, 50, 60].map((at) => `${at},${(at * 1.001).toFixed(3)}`).join("\n");
  await page.getByLabel("Measured files").setInputFiles([file("good.csv", table((at) => 0.002 * at)), file("odd.csv", `x,y\n${rows}\n`)]);
  const form = page.getByRole("region", { name: "Say which column is which: odd.csv" });
  check(await seen(form), "in a drop of several the table that is not read is asked about");
  check(await page.getByRole("region", { name: "What was read" }).getByText("good.csv").count() > 0, "and the other is answered");
  await check.shot("columns");
  await form.getByRole("button", { name: "Answer again" }).click();
  check(await seen(page.getByRole("region", { name: "What was read" }).getByText("odd.csv")), "with its columns it is answered");
}

async function several(page, check) {
  const files = [file("one.csv", table((_at, sense) => -0.02 * sense)), file("two.csv", table((at) => 0.001 * at)),
    file("notes.txt", "nothing was measured here\nand nothing there\n")];
  await page.getByLabel("Measured files").setInputFiles(files);
  check(await seen(page.getByRole("alert")), "the file that cannot be read is named");
  check(await page.getByRole("alert").getByText("notes.txt").count() > 0, "the refusal says which file");
  const tabs = page.getByRole("tab");
  await seen(tabs.first());
  check(await tabs.count() === 2, "the other files are answered, one tab each");
  await tabs.first().focus();
  await page.keyboard.press("ArrowRight");
  check(await tabs.nth(1).getAttribute("aria-selected") === "true", "arrow keys change tabs");
}

async function refusedAndBack(page, check) {
  await page.getByText("Paste text instead").click();
  await page.getByLabel("Log or table").fill("reading one,reading two\n10,10.02\n20,20.04\n30,30.06\n40,40.08\n50,50.10\n60,60.12\n");
  await page.getByRole("button", { name: "Diagnose this text" }).click();
  check(await seen(page.getByRole("region", { name: "What was read" }).getByText("pasted.txt")), "pasted text is read as a file");
  const list = page.getByRole("region", { name: "Answers of this visit" });
  check(await list.getByRole("button").count() >= 4, "earlier answers are listed");
  await list.getByRole("button", { name: "example_backlash.csv" }).click();
  check(await seen(heading(page, /^X loses 0\.0\d+ ± [\d.]+ mm at its reversals/)), "an earlier answer comes back");
}

// Errors stand on the places alone, then on the machine that is chosen; a machine that does not
// go with the file leaves the answer as it is.
async function drawn(page, check) {
  await page.getByLabel("Measured files").setInputFiles([file("backlash.csv", table((_at, sense) => -0.02 * sense))]);
  const card = page.getByRole("region", { name: "The error, drawn larger than it is" });
  await seen(heading(page, /^X loses 0\.04\d* ± [\d.]+ mm at its reversals/));
  await card.scrollIntoViewIfNeeded();
  check(await seen(card.locator("canvas[data-drawn='measured places']")), "without a machine only the places are drawn");
  check(await seen(card.getByText(/Largest: (19|20|21)(\.\d)? µm/)), "the legend has the largest error");
  const looks = () => card.locator(".mac-view").screenshot().then((png) => png.toString("base64"));
  await page.waitForTimeout(500);
  const before = await looks();
  await card.getByRole("slider").fill("0.2");
  await page.waitForTimeout(500);
  check((await looks()) !== before, "the slider changes the drawing");
  const machine = page.getByRole("combobox", { name: "Machine" });
  await machine.selectOption("gantry_router");
  check(await seen(card.locator("canvas[data-drawn='gantry_router']")), "the machine chosen is drawn");
  check(await seen(card.getByText("The file does not tell Y and Z")), "what the file does not tell is said");
  await machine.selectOption("delta_printer");
  check(await seen(page.getByText("That does not go with this file")), "a machine that does not go with the file is refused beside the choice");
  check(await heading(page, /^X loses 0\.04\d* ± [\d.]+ mm at its reversals/).isVisible(), "the answer before stays");
  await machine.selectOption("");
}

export async function diagnose(page, base, check) {
  await page.goto(`${base}/nosuch`);
  await page.getByRole("heading", { name: "There is no such page" }).waitFor();
  check(await page.locator("[aria-current=page]").count() === 0, "an address that leads nowhere is called so");
  const outside = [];
  page.on("request", (request) => {
    if (!request.url().startsWith(base) && !/^(data|blob):/.test(request.url())) outside.push(request.url());
  });
  await page.goto(new URL("/diagnose", base).href);
  check(await seen(page.getByRole("heading", { level: 1, name: "What is wrong with my machine?" })), "the page opens");
  check(await seen(page.getByText("Nothing leaves this computer.")), "it says that nothing leaves the computer");
  await examples(page, check);
  await settings(page, check);
  await drawn(page, check);
  await several(page, check);
  await refusedAndBack(page, check);
  const report = page.getByRole("link", { name: /Whole report/ });
  check((await page.request.get(new URL(await report.getAttribute("href"), base).href)).ok(), "the whole report opens");
  await assumed(page, check);
  await columnsOfOne(page, check);
  await sameAsSummary(page, base, check);
  check(outside.length === 0, "no request leaves the server");
}
