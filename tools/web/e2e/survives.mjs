// The server is killed with -9 while a procedure waits for an answer; the wizard goes on.
export async function survives(page, base, check) {
  await page.goto(`${base}/calibrate`);
  await page.getByRole("button", { name: /home/i }).first().click();
  await page.waitForFunction(async () => {
    const bench = await (await fetch("/api/bench")).json();
    return bench.state === "idle" && bench.results.length > 0;
  });
  const send = (path, body) => page.evaluate(async ([to, what]) => (await fetch(to, {
    method: to.endsWith("session") ? "PATCH" : "POST",
    headers: { "Content-Type": "application/json" },
    body: JSON.stringify(what),
  })).status, [path, body]);
  const began = await send("/api/bench/procedures",
    { procedure: "next_cluster_backlash", options: { axis: "x" } });
  check(began === 202, "a procedure begins");
  await page.getByRole("button", { name: "Apply", exact: true }).waitFor();
  await check.killAndRestart();
  await page.waitForFunction(async () => {
    try {
      return (await (await fetch("/api/bench")).json()).state === "idle";
    } catch {
      return false;
    }
  }, undefined, { timeout: 15000 });
  await page.reload();
  const bench = await page.evaluate(async () => (await fetch("/api/bench")).json());
  check(bench.results.length > 0, "results from before the kill are there");
  check(await send("/api/bench/procedures",
    { procedure: "next_cluster_backlash", options: { axis: "x" } }) === 202, "it begins again");
  await page.getByRole("button", { name: "Apply", exact: true }).click();
  await page.waitForFunction(async () => {
    const now = await (await fetch("/api/bench")).json();
    return now.state === "idle" && now.settings.backlash_mm.x > 0.05;
  });
  check(true, "the correction is applied after the kill");
}
