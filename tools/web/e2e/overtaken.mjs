// An answer that was on its way while the machine went on does not undo what an event has told.
const begin = (base, procedure, options) => fetch(`${base}/api/bench/procedures`, {
  method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify({ procedure, options }),
});

// The seat must be free where the state says so.
async function oneAfterTheOther(base, check) {
  let taken = 0;
  for (let i = 0; i < 20; ++i) {
    taken += (await begin(base, "home", {})).status === 202 ? 1 : 0;
    await check.until((bench) => bench.state === "idle", 0);
  }
  check(taken === 20, `a job begins as soon as the machine is idle: ${taken} of 20`);
}

export async function overtaken(page, base, check) {
  await oneAfterTheOther(base, check);
  // Made while the machine is idle, handed over when it has asked already.
  let handOver;
  const isAsked = new Promise((done) => { handOver = done; });
  const held = [];
  await page.route("**/api/bench", async (route) => {
    const response = await route.fetch();
    held.push(isAsked.then(() => route.fulfill({ response })));
  });
  const isOpen = page.waitForResponse(/\/api\/events$/);
  await page.goto(`${base}/calibrate`);
  await isOpen;
  await page.waitForTimeout(500);
  check(held.length > 0, "the page asks for the state of the bench");
  await begin(base, "next_cluster_backlash", { axis: "x" });
  const apply = page.getByRole("button", { name: "Apply", exact: true });
  await apply.waitFor();
  handOver();
  await Promise.all(held);
  await page.waitForTimeout(500);
  check(await apply.isVisible(), "a late answer does not take the question away");
  await apply.click({ timeout: 3000 });
  await check.until((bench) => bench.state === "idle" && bench.settings.backlash_mm.x > 0.05);
  check(true, "the question is answered and the change applied");
}
