// Drives the page "Calibrate" against a fresh server with practice machines, `--fidelity fast`.
const patience = 8000;

async function api(base, path) {
  return (await fetch(`${base}/api/bench${path}`)).json();
}

// Waits until `tells` holds of the bench.
async function until(base, tells) {
  for (let i = 0; i < 80; ++i) {
    const bench = await api(base, "");
    if (tells(bench)) return bench;
    await new Promise((done) => setTimeout(done, 100));
  }
  return api(base, "");
}

const endingOf = (bench, id) => bench.results.find((job) => job.id > id && job.result)?.result.ending;
const newest = (bench) => Math.max(0, ...bench.results.map((job) => job.id));

const hasFocus = (locator) => locator.evaluate((one) => one === document.activeElement);

// From the first page of all; every click is counted.
async function fromTheStart(page, base, check) {
  let clicks = 0;
  const click = async (locator) => { ++clicks; await locator.click(); };
  await page.goto(`${base}/`);
  await click(page.getByRole("link", { name: "Calibrate" }));
  await page.getByRole("heading", { level: 1, name: "Calibrate" }).waitFor({ timeout: patience });
  await click(page.getByRole("button", { name: "Home the machine and go on" }));
  const step2 = page.getByRole("heading", { name: /^Step 2 of 6/ });
  await step2.waitFor({ timeout: patience });
  check(true, "homing leads to step 2 by itself");
  await page.waitForTimeout(300);
  check(await hasFocus(step2), "the focus goes to the next step's heading");
  await click(page.getByRole("button", { name: "Measure X, Y, Z" }));
  for (const id of [1, 2]) {
    await until(base, (bench) => bench.job?.question?.id === id);
    await click(page.getByRole("button", { name: /^Use what the simulated gauge reads/ }));
  }
  const asked = page.getByRole("dialog", { name: "Apply this change?" });
  await asked.waitFor({ timeout: patience });
  check(await asked.getByText(/steps\/mm of X/).count() > 0, "a change says what it would set");
  await click(asked.getByRole("button", { name: "Apply", exact: true }));
  const applied = (one) => one.job?.said.some((text) => text.startsWith("steps_per_mm.x: 800.0000 -> 797"));
  check(applied(await until(base, applied)) && clicks <= 6, `from the first page ${clicks} clicks apply steps/mm of X`);
}

async function abortAndEntries(page, base, check) {
  await page.getByRole("dialog").first().waitFor({ timeout: patience });
  await page.getByRole("button", { name: "Abort" }).click();
  const bench = await until(base, (one) => one.state === "idle");
  check(bench.state === "idle", "Abort ends the job that asks");
  await page.waitForTimeout(300);
  check(await hasFocus(page.getByRole("status").filter({ hasText: "The machine is idle." })), "after Abort the focus is on the status");
  await check.shot("aborted");
  const settings = page.getByRole("region", { name: "Settings in force" });
  check(await settings.getByText(/^797\.\d+ steps\/mm, measured and applied, not verified$/).count() === 1, "what was applied before the stop is not called unmeasured");
  const values = page.getByRole("region", { name: /^Values: Rough steps/ }).first();
  check(await values.getByText(/^797\.\d+ steps\/mm, uncertainty not known$/).count() === 1, "the readings say what was applied");
  check(await page.getByText(/as a whole, not its parts|[XYZ] - 2 where/).count() === 0, "no formula of names stands in a sentence");
  await page.getByText("I have measured by hand already").click();
  await page.getByLabel("Y: measured, mm").fill("99.75");
  await page.getByText(/= 802\.005 steps\/mm/).waitFor({ timeout: patience });
  const kept = await until(base, (one) => one.session.entries.manual?.y?.measured === "99.75");
  check(kept.session.entries.manual?.y?.measured === "99.75", "a manual reading is kept on the server");
}

async function reloadWhileAsked(page, base, check) {
  await page.getByRole("checkbox", { name: "Y", exact: true }).uncheck();
  await page.getByRole("checkbox", { name: "Z", exact: true }).uncheck();
  await page.getByRole("navigation", { name: "Steps" }).getByRole("button", { name: /Precise steps/ }).click();
  await page.getByRole("button", { name: "Measure X", exact: true }).click();
  await page.getByRole("dialog", { name: "Turn the block" }).waitFor({ timeout: patience });
  await page.reload();
  await page.getByRole("dialog", { name: "Turn the block" }).waitFor({ timeout: patience });
  check(await page.getByRole("heading", { name: /^Step 3 of 6/ }).count() === 1, "a reload keeps the step and the question");
  check(!(await page.getByRole("checkbox", { name: "Y", exact: true }).isChecked().catch(() => false)), "a reload keeps the chosen axes");
  const before = newest(await api(base, ""));
  await page.getByRole("checkbox", { name: /Let the simulated machine turn/ }).click();
  const bench = await until(base, (one) => one.state === "idle" && newest(one) > before);
  check(endingOf(bench, before) === "done", "after the reload the job runs to its end");
}

async function backlashWithClusters(page, base, check) {
  await page.getByRole("button", { name: "Next: Backlash" }).click();
  await page.getByRole("button", { name: "Measure X", exact: true }).click();
  await page.getByRole("dialog", { name: "Apply this change?" }).waitFor({ timeout: patience });
  check(await page.getByText(/the two clusters lie [\d.]+ µm apart/).count() > 0, "readings show two clusters while it runs");
  await page.getByRole("button", { name: "Apply", exact: true }).click();
  await page.getByText(/Backlash of X is now 0\.06/).waitFor({ timeout: patience });
  check(true, "backlash of X is applied and told");
}

async function reportAndRestore(page, base, check) {
  await page.getByRole("navigation", { name: "Steps" }).getByRole("button", { name: /Verification/ }).click();
  await page.getByLabel("Gauge for the reversal check").selectOption("none");
  await page.getByRole("button", { name: "Verify X", exact: true }).click();
  await page.getByText(/checks are (beyond|within)|within their limits/).first().waitFor({ timeout: patience });
  check(await page.getByRole("region", { name: "Checks" }).count() === 1, "verification shows its checks");
  check(await page.getByText(/M425 X0\.06/).count() > 0, "the settings to keep hold the backlash");
  await page.getByRole("button", { name: "Restore the settings from before" }).click();
  await page.getByRole("button", { name: "Yes, restore" }).click();
  const bench = await until(base, (one) => one.settings.backlash_mm.x === 0 && one.state === "idle");
  check(bench.settings.backlash_mm.x === 0 && bench.settings.steps_per_mm.x === 800, "restore puts every setting back");
  check(bench.calibrated_at === null, "after restoring no calibration is claimed");
  await page.getByText(/^undone: settings restored/).waitFor({ timeout: patience });
  // The file is fetched anew after the status has changed.
  await page.getByText(/Last calibrated/).waitFor({ state: "detached", timeout: patience });
  check(true, "the settings to keep bear no date after restoring");
}

export async function calibrate(page, base, check) {
  try {
    await fromTheStart(page, base, check);
    await abortAndEntries(page, base, check);
    await reloadWhileAsked(page, base, check);
    await backlashWithClusters(page, base, check);
    await reportAndRestore(page, base, check);
  } finally {
    await fetch(`${base}/api/bench/abort`, { method: "POST" });
    await until(base, (bench) => bench.state === "idle");
  }
}
