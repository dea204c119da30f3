// An answer that was on its way while the machine went on does not undo what an event has told.
async function until(base, tells) {
  for (let i = 0; i < 80; ++i) {
    const bench = await (await fetch(`${base}/api/bench`)).json();
    if (tells(bench)) return;
    await new Promise((done) => setTimeout(done, 100));
  }
  throw new Error("the bench does not get there");
}

const begin = (page, base, procedure, options) =>
  page.request.post(`${base}/api/bench/procedures`, { data: { procedure, options } });

export async function overtaken(page, base, check) {
  await begin(page, base, "home", {});
  await until(base, (bench) => bench.state === "idle" && bench.results.length > 0);
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
  await begin(page, base, "next_cluster_backlash", { axis: "x" });
  const apply = page.getByRole("button", { name: "Apply", exact: true });
  await apply.waitFor();
  handOver();
  await Promise.all(held);
  await page.waitForTimeout(500);
  check(await apply.isVisible(), "a late answer does not take the question away");
  await apply.click({ timeout: 3000 });
  await until(base, (bench) => bench.state === "idle" && bench.settings.backlash_mm.x > 0.05);
  check(true, "the question is answered and the change applied");
}
