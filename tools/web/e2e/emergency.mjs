// The emergency stop: on every page that moves a machine, while a job runs, for onlookers, by keyboard.
const stopOf = (page) => page.getByRole("button", { name: "Emergency stop" });

async function everywhere(page, base, check) {
  for (const path of ["/calibrate", "/bed", "/machine"]) {
    await page.goto(base + path);
    await stopOf(page).waitFor();
    await page.evaluate(() => scrollTo(0, document.body.scrollHeight));
    const box = await stopOf(page).boundingBox();
    check(box.y >= 0 && box.y + box.height <= page.viewportSize().height, `${path} has it in sight, also scrolled down`);
  }
}

// A job that somebody else began, stopped by keyboard from a page that only looks on.
async function onlooker(page, base, check) {
  await page.goto(`${base}/machine`);
  const begun = await fetch(`${base}/api/bench/procedures`, { method: "POST",
    headers: { "Content-Type": "application/json", "X-Operator": "somebody else" },
    body: JSON.stringify({ procedure: "next_cluster_backlash", options: { axis: "x" } }) });
  check(begun.status === 202, "somebody else moves the machine");
  for (let i = 0; i < 12 && !(await stopOf(page).evaluate((one) => one === document.activeElement)); ++i) await page.keyboard.press("Tab");
  await page.keyboard.press("Enter");
  const heading = page.getByRole("heading", { name: "Emergency stop" });
  await heading.waitFor();
  check(true, "by keyboard, within twelve tabs, without a question");
  const bench = await check.until((one) => one.state === "idle" && one.results.length > 0);
  check(bench.results.at(-1).result.ending === "aborted", "it ends the job of somebody else");
  check(await page.getByText("The job at work was ended.").isVisible(), "the page says in words that it stopped");
  check(await heading.evaluate((one) => one === document.activeElement), "the focus is on what it says");
  await check.accessible("with the machine stopped");
  await check.shot("stopped");
}

async function goOn(page, check) {
  await page.getByRole("button", { name: "Home after the stop" }).click();
  await page.getByText("The machine is homed. You can go on").waitFor();
  const bench = await check.until((one) => one.state === "idle");
  check(bench.results.at(-1).procedure === "home", "the page leads on: the machine is homed");
  await page.getByRole("button", { name: "Close this note" }).click();
  check(await page.getByRole("heading", { name: "Emergency stop" }).count() === 0, "the note can be closed");
}

// What a real machine answers, and no answer at all.
async function otherAnswers(page, check) {
  await page.route("**/api/bench/emergency-stop", (route) => route.fulfill({ status: 202, json: { aborted: true, sent_m112: true } }));
  await stopOf(page).click();
  await page.getByText(/the server sent M112 to the controller/).waitFor();
  check(await page.getByRole("button", { name: "Home after the stop" }).isDisabled(), "a halted controller is reset before it is homed");
  await check.shot("halted");
  await page.getByRole("button", { name: "Reset the controller" }).click();
  await page.getByText("The controller is reset. Home the machine next.").waitFor();
  await page.unroute("**/api/bench/emergency-stop");
  await page.route("**/api/bench/emergency-stop", (route) => route.abort());
  await stopOf(page).click();
  await page.getByText("The machine may still move. Press the emergency stop at the machine itself.").waitFor();
  check(true, "where the server is silent the page says so");
  await page.unroute("**/api/bench/emergency-stop");
}

async function atBed(page, base, check) {
  await page.goto(`${base}/bed`);
  await page.getByRole("button", { name: /^Measure/ }).click();
  await page.getByRole("heading", { name: "What was measured" }).waitFor();
  await page.getByRole("button", { name: "Apply…" }).click();
  const dialog = page.getByRole("dialog", { name: "Move the screws?" });
  await dialog.getByRole("button", { name: "Emergency stop" }).click();
  await dialog.waitFor({ state: "hidden" });
  check(true, "a dialog that covers the page has a stop of its own");
}

// Three axes are chosen, and the first asks whether to apply: whoever ends it, by whatever means, no
// other axis begins by itself.
async function noAxisFollows(page, base, check) {
  const begun = [];
  page.on("request", (one) => { if (one.method() === "POST" && one.url().endsWith("/api/bench/procedures")) begun.push(one.postData()); });
  const post = (path) => fetch(base + path, { method: "POST" });
  const ways = {
    "the emergency stop": () => stopOf(page).first().click(),
    "the page's Abort": () => page.getByRole("button", { name: /^Abort/ }).first().click(),
    "an abort from elsewhere": () => post("/api/bench/abort"),
    "an emergency stop from elsewhere": () => post("/api/bench/emergency-stop"),
  };
  for (const [way, end] of Object.entries(ways)) {
    await post("/api/bench/abort");
    await check.until((one) => one.state === "idle");
    await fetch(`${base}/api/bench/procedures`, { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify({ procedure: "home", options: {} }) });
    await check.until((one) => one.state === "idle" && !one.is_stopped);
    await page.goto(`${base}/calibrate`);
    await page.getByRole("button", { name: /^4\. Backlash/ }).click();
    await page.getByRole("button", { name: /^(Measure|Repeat|Continue with) .*Y/ }).first().click();
    await check.until((one) => one.state === "asking");
    begun.length = 0;
    await end();
    await check.until((one) => one.state === "idle");
    await page.waitForTimeout(1500);
    const { bench } = { bench: await (await fetch(`${base}/api/bench`)).json() };
    check(begun.length === 0 && bench.state === "idle", `after ${way} no other axis begins`);
  }
  await page.getByRole("heading", { name: "Emergency stop" }).waitFor({ state: "hidden" });
  check(true, "once somebody has gone on, the note of the first stop is gone");
}

export async function emergency(page, base, check) {
  await everywhere(page, base, check);
  await onlooker(page, base, check);
  await goOn(page, check);
  await otherAnswers(page, check);
  await atBed(page, base, check);
  await noAxisFollows(page, base, check);
}
