// The server is killed with -9 while a procedure waits for an answer; the wizard goes on.
export async function survives(page, base, check) {
  await page.goto(`${base}/calibrate`);
  await page.getByRole("button", { name: /home/i }).first().click();
  await check.until((bench) => bench.state === "idle" && bench.results.length > 0);
  const begin = async () => (await page.request.post(`${base}/api/bench/procedures`,
    { data: { procedure: "next_cluster_backlash", options: { axis: "x" } } })).status();
  check(await begin() === 202, "a procedure begins");
  await page.getByRole("button", { name: "Apply", exact: true }).waitFor();
  await check.killAndRestart();
  await check.until((bench) => bench.state === "idle");
  await page.reload();
  const bench = await check.until(() => true);
  check(bench.results.length > 0, "results from before the kill are there");
  check(await begin() === 202, "it begins again");
  await page.getByRole("button", { name: "Apply", exact: true }).click();
  const after = await check.until((now) => now.state === "idle" && now.results.length > bench.results.length);
  check(after.settings.backlash_mm.x > 0.05, "the correction is applied after the kill");
}
