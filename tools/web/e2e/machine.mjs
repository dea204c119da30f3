// The machine page against fresh practice machines: a run played back, and the bench followed.
const shownAs = (page) => page.locator("canvas[data-drawn]").waitFor();

// A checksum of what the canvas shows: a screenshot, for its picture is not kept.
const looks = (page) => page.locator(".mac-view").screenshot().then((png) => png.toString("base64"));

// The share of pixels that differ visibly. Two drawings of the same are alike but for edges,
// which fall otherwise where the page is laid out a fraction of a pixel lower.
const share = (page, one, other) => page.evaluate(async (pictures) => {
  const [a, b] = await Promise.all(pictures.map(async (base64) => {
    const bytes = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
    const bitmap = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
    const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
    context.drawImage(bitmap, 0, 0);
    return context.getImageData(0, 0, bitmap.width, bitmap.height);
  }));
  if (a.width !== b.width || a.height !== b.height) return 1;
  let differ = 0;
  for (let i = 0; i < a.data.length; i += 4) {
    if ([0, 1, 2].some((k) => Math.abs(a.data[i + k] - b.data[i + k]) > 24)) differ += 1;
  }
  return differ / (a.width * a.height);
}, [one, other]);

// Poses and scenes that were asked for: until they come the machine stands still, and elsewhere.
const poses = { open: 0, endedAt: 0 };

function watchPoses(page) {
  const isOfPoses = (request) => /\/(poses|scene)\b/.test(request.url());
  const end = (request) => {
    if (!isOfPoses(request)) return;
    poses.open -= 1;
    poses.endedAt = Date.now();
  };
  page.on("request", (request) => { if (isOfPoses(request)) poses.open += 1; });
  page.on("requestfinished", end);
  page.on("requestfailed", end);
}

// Once nothing moves any more, and from where the page begins: scrolled, edges fall between pixels.
async function looksAtLast(page) {
  await page.evaluate(() => scrollTo(0, 0));
  for (let before = "", now = await looks(page); ; before = now) {
    await page.waitForTimeout(1000);
    now = await looks(page);
    if (now === before && poses.open === 0 && Date.now() - poses.endedAt > 1000) return now;
  }
}

async function playBack(page, base, check) {
  const button = (name) => page.getByRole("button", { name });
  await page.goto(`${base}/machine`);
  await page.getByRole("heading", { name: "Machine", level: 1 }).waitFor();
  await page.getByText(/^\d+ scenarios$/).waitFor();
  check(await button("Run it").isDisabled(), "nothing runs before a scenario is chosen");
  await page.getByRole("button", { name: /^A printer: its three screws/ }).click();
  check(page.url().endsWith("?scenario=tz_levels_in_one_round"), "there is a scenario to start with");
  await page.goto(`${base}/machine`);
  await page.getByText(/^\d+ scenarios$/).waitFor();
  await page.getByLabel("Search").fill("nothing has this word");
  check(await page.getByText("No scenario has these words").isVisible(), "a search without a hit says so");
  await page.getByLabel("Search").fill("bent bed told apart");
  await page.getByRole("listbox", { name: "All scenarios" }).selectOption("tz_bent_bed_is_told_apart");
  await shownAs(page);
  check(page.url().endsWith("?scenario=tz_bent_bed_is_told_apart"), "the address names the scenario");
  await button("Run it").click();
  await page.getByRole("heading", { name: "Result" }).waitFor();
  check(await page.getByText("That is what this scenario expects.").first().isVisible(), "the verdict comes in words");
  const slope = await page.getByRole("row", { name: /^Tilt of the bed, slope along X/ }).innerText();
  check(/4\.00 mrad\s+4\.00 ± \d/.test(slope), "built in and found stand side by side, with uncertainty");

  const where = page.getByLabel(/Where in the run/);
  await button("Line on ▸").click();
  const first = await page.locator(".mac-now").innerText();
  check(/^G30 X20 Y20 S-1 ends at X 20\.000, Y 20\.000/.test(first), "the first touch after homing is the next line");
  check((await page.locator("li[aria-current]").innerText()).includes("G30 X20 Y20"), "the list marks the same line");
  const before = await looks(page);
  await where.fill("40");
  await page.waitForTimeout(600);
  check((await looks(page)) !== before, "the drawing follows the slider");
  await page.getByRole("button", { name: "Play", exact: true }).click();
  await button("Pause").click();
  check(Number(await where.inputValue()) >= 40, "Play goes on from there");
  await page.getByText(/changes of settings/).click();
  await button(/M584/).first().click();
  check((await page.locator(".mac-now").innerText()).startsWith("M584 Z0 U1 V2"), "a change of a setting is one click away");
  check((await page.locator(".mac-code li").count()) <= 40, "forty lines are in the list at most");
}

// The cause that a run names stands first, whole, and every figure has its name and unit in words.
async function namesTheCause(page, base, check) {
  const result = page.getByRole("region", { name: "Result" });
  const run = async (scenario) => {
    await page.goto(`${base}/machine?scenario=${scenario}`);
    await page.getByRole("button", { name: "Run it" }).click();
    await result.getByText("That is what this scenario expects.").waitFor();
    return (await result.locator("strong").allInnerTexts()).join(" ");
  };
  const debris = await run("trouble_bed_debris");
  check(/^One touch, at \(118, 20\), lies 0\.\d+ mm above .* debris on the bed, not the probe/.test(debris), "debris is named in the first sentence");
  check(await result.getByText("finds the hidden errors").count() === 0, "and no success is claimed in its place");
  await check.shot("debris");
  const drift = await run("trouble_inconsistent_drift");
  check(/they drift: -1\.\d+ µm from touch to touch/.test(drift), "a drift is named in the first sentence");
  check(await result.getByText(/\bsaid$|[a-z]_[a-z]/).count() === 0, "no fragment of a pattern and no key is shown");
  await run("tz_levels_in_one_round");
  const row = await result.getByRole("row", { name: /off level/ }).first().innerText();
  check(/below [\d.]+ mm\s+[\d.e-]+ mm/.test(row), "a check has its unit");
}

async function exaggerateAndRefuse(page, base, check) {
  await page.goto(`${base}/machine?scenario=delta_unlike_rods_jointly`);
  await shownAs(page);
  const slider = page.getByLabel(/Errors drawn/);
  const plain = await looks(page);
  await slider.fill("0.4");
  await page.getByText("Errors drawn 10 times as large").waitFor();
  await page.waitForTimeout(600);
  check((await looks(page)) !== plain, "errors drawn larger change the drawing");
  await slider.fill("1");
  await page.getByText("Choose smaller errors.").waitFor();
  check(await page.locator("canvas[data-drawn]").isVisible(), "errors too large to draw are refused, and the drawing stays");
  await page.getByRole("application").focus();
  const from = await looks(page);
  await page.keyboard.press("ArrowLeft");
  await page.waitForTimeout(300);
  check((await looks(page)) !== from, "an arrow key turns the machine");
}

async function standsStill(page, base, check) {
  await page.goto(`${base}/machine?scenario=motor_axis_sync`);
  await page.getByText("shown standing still").waitFor();
  await page.getByRole("button", { name: "Run it" }).click();
  const transcript = page.getByRole("group", { name: "Transcript" });
  await transcript.waitFor();
  check((await transcript.innerText()).includes("> M814 X"), "a machine without a tip shows its transcript as text");
}

async function watch(page, base, check) {
  await page.getByRole("button", { name: "Watch the machine live" }).click();
  await page.getByText("Nothing is at work, and nothing was.").waitFor();
  await shownAs(page);
  const before = await looks(page);
  const post = (path, data) => page.request.post(`${base}/api/bench/${path}`, { data });
  const begun = await post("procedures", { procedure: "next_cluster_backlash", options: { axis: "x" } });
  check(begun.ok(), "a procedure begins on the bench");
  await page.getByText(/The newest of \d+ readings/).waitFor();
  await page.waitForTimeout(700);
  check((await looks(page)) !== before, "the tip goes where the readings are");
  const sent = await page.getByRole("list", { name: "The newest lines of G-code" }).innerText();
  check(/G38\.\d/.test(sent) && sent.split("\n").length <= 12, "the newest lines of G-code stand beside it, the probe's among them");
  await post("abort", {});
  await page.getByText(/Nothing is at work. The last was: Backlash, X\. Stopped on request\./).waitFor();
  check(true, "the page says that the work has ended");
}

// The bench is a twin: what lies on its table and its hidden errors are drawn.
async function enlargesTheBench(page, check) {
  await page.getByText("On its table: the 1-2-3 block (76.2 × 50.8 × 25.4 mm)").waitFor();
  // Not before the tip, its dots and the block have come to where they stand.
  let plain = await looksAtLast(page);
  for (let looked = 0; looked < 20; looked += 1) {
    await page.waitForTimeout(500);
    const again = await looksAtLast(page);
    const moved = await share(page, plain, again);
    plain = again;
    if (moved < 0.0005) break;
  }
  const asked = page.waitForRequest(/\/api\/bench\/scene\?exaggerate=300$/);
  await page.getByLabel(/Errors drawn as they are/).fill("1");
  await asked;
  await page.getByText("Errors drawn 300 times as large").waitFor();
  await page.waitForTimeout(600);
  check((await looksAtLast(page)) !== plain, "the hidden errors of the bench are drawn larger");
  await check.shot("bench");
  // The words change at once, the drawing once it has come, and the tip goes to its place then.
  const anew = page.waitForResponse((one) => /\/api\/bench\/scene/.test(one.url()))
    .then(() => page.waitForResponse((one) => /\/api\/bench\/poses/.test(one.url())));
  await page.getByLabel(/Errors drawn/).fill("0");
  await page.getByText("Errors drawn as they are (1×)").waitFor();
  await anew;
  // On a busy computer the tip may still be on its way.
  let moved = 1;
  for (let looked = 0; looked < 20 && moved >= 0.002; looked += 1) {
    if (looked > 0) await page.waitForTimeout(250);
    moved = await share(page, plain, await looksAtLast(page));
  }
  check(moved < 0.002, `drawn as they are again, tip and dots stand where they stood (${moved})`);
}

// The scene that the page draws holds the block, as large as its words say.
async function holdsTheBlock(page, base, check) {
  const scene = page.waitForResponse(/\/api\/bench\/scene/);
  await page.goto(`${base}/machine`);
  await page.getByRole("button", { name: "Watch the machine live" }).click();
  const { geoms } = await (await scene).json();
  await shownAs(page);
  check(geoms.some(({ size_mm }) => size_mm.join() === "38.1,25.4,12.7"), "the scene of the bench holds its block");
}

// Paints while the tip goes to two readings: poses are held back until the machine stands drawn.
async function paintsOf(page, base, reducedMotion) {
  await page.emulateMedia({ reducedMotion });
  await page.goto(`${base}/machine`);
  await page.evaluate(() => {
    window.paints = 0;
    const render = WebGL2RenderingContext.prototype.clear;
    WebGL2RenderingContext.prototype.clear = function (...all) { window.paints++; return render.apply(this, all); };
  });
  const held = [];
  await page.route(/\/poses/, async (route) => {
    const response = await route.fetch();
    await new Promise((go) => held.push(go));
    await route.fulfill({ response });
  });
  // Until nothing has been painted for a second.
  const settled = async () => {
    for (let before = -1, now = 0; before !== now;) {
      before = now;
      await page.waitForTimeout(1000);
      now = await page.evaluate(() => window.paints);
    }
  };
  await page.getByRole("button", { name: "Watch the machine live" }).click();
  await shownAs(page);
  await page.waitForTimeout(500);
  await settled();
  await page.evaluate(() => { window.paints = 0; });
  for (const go of held) go();
  await settled();
  await page.unroute(/\/poses/);
  return page.evaluate(() => window.paints);
}

async function glides(page, base, check) {
  // A made-up bench: a real one is too quick.
  const bench = await (await page.request.get(`${base}/api/bench`)).json();
  const reading = (x) => ({ campaign: "repeatability.x", feature: "block.left", setup: "", n: { x: 1, y: 0, z: 0 }, dir: { x: 1, y: 0, z: 0 }, at_mm: { x, y: 150, z: 20 }, value_mm: x });
  bench.is_twin = false;
  bench.job = { ...bench.job, id: 99, readings: [reading(20), reading(280)] };
  await page.route("**/api/bench", (route) => route.fulfill({ json: bench }));
  const [steps, tweens] = [await paintsOf(page, base, "reduce"), await paintsOf(page, base, "no-preference")];
  check(tweens > steps + 4, `the tip glides from reading to reading: ${tweens} paints, ${steps} where motion is unwanted`);
  const row = await page.getByRole("row", { name: /left face of the block/ }).first().innerText();
  check(row.startsWith("Repeatability, X"), "readings have names, not keys");
  check(await page.getByText("The workpiece is not drawn").isVisible(), "what is not drawn is said");
  check(await page.getByText("whose errors nobody knows, so there is nothing to enlarge").isVisible()
    && await page.getByLabel(/Errors drawn/).count() === 0, "a real machine has no slider, and the page says why");
  await page.unroute("**/api/bench");
}

export async function machine(page, base, check) {
  watchPoses(page);
  await page.setViewportSize({ width: 1000, height: 600 });
  await playBack(page, base, check);
  await check.accessible?.("with a run played back");
  await namesTheCause(page, base, check);
  await exaggerateAndRefuse(page, base, check);
  await standsStill(page, base, check);
  await watch(page, base, check);
  await enlargesTheBench(page, check);
  await holdsTheBlock(page, base, check);
  await check.accessible?.("at the bench");
  await glides(page, base, check);
  await page.setViewportSize({ width: 390, height: 800 });
  const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
  check(wide <= 0, "nothing scrolls sideways on a phone");
}
