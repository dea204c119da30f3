// The bed page against a fresh practice printer: measure, apply, check, take back, validate.
const rowOf = async (page, table, row) =>
  (await page.getByRole("table").filter({ hasText: table }).getByRole("row", { name: row }).getByRole("cell").allInnerTexts()).map(Number);

// Four equal corners: the middle may be anywhere.
async function fourCorners(page, check) {
  await page.getByText("Write in heights you measured yourself").click();
  await page.getByLabel("Heights: x, y, z").fill("20 20 0\n200 20 0\n20 200 0\n200 200 0");
  await page.getByRole("button", { name: "Use these heights" }).click();
  await page.getByRole("heading", { name: /^Twist: the touches lie 0\.0 µm off a plane/ }).waitFor();
  check(await page.getByText("The bed is flat").count() === 0, "four equal corners are not called a flat bed");
  check(await page.getByText(/A bowl, a dome or a saddle .* measure a 3×3 grid/).isVisible(), "it says what four corners cannot tell, and what to measure");
  await check.shot("corners");
  await page.getByText("Write in heights you measured yourself").click();
}

// Heights of another gauge against the plane as it stands.
async function validates(page, check) {
  const button = (name) => page.getByRole("button", { name });
  const points = page.getByLabel(/Test points/);
  await button("Compare").click();
  await page.getByText(/Within the target/).waitFor();
  await points.fill("50, 50, nine");
  await button("Compare").click();
  check(await page.getByText(/is not three numbers/).isVisible(), "a broken line is named");
  await points.fill("50, 50, 9");
  await button("Compare").click();
  await page.getByText(/Beyond the target/).waitFor();
  check(true, "points far off the plane are beyond the target");
}

export async function bed(page, base, check) {
  const button = (name) => page.getByRole("button", { name });
  const heading = (name) => page.getByRole("heading", { name });
  await page.goto(`${base}/bed`);
  await heading("Level the bed").waitFor();
  await page.getByText("not measured yet", { exact: true }).waitFor();
  check(await page.getByText("nobody now").isVisible(), "nobody is at the machine at the start");

  await page.getByLabel("Rows (along y)").selectOption("4");
  check(await button("Measure (12 touches)").isVisible(), "the grid chosen says how many touches");
  await button("Measure (12 touches)").press("Enter");
  check(await button("Measure (12 touches)").evaluate((one) => one === document.activeElement), "a measurement begun by keyboard keeps the focus");
  await heading("What was measured").waitFor();
  const isThere = (one) => one.waitFor().then(() => true, () => false);
  check(await isThere(page.getByText(/The bed is tilted by/)), "the verdict comes in words");
  await page.getByText("Table of the 12 touches").click();
  const touches = page.getByRole("region", { name: "Touches" }).getByRole("row");
  check((await touches.count()) === 13, "each touch has a row in the table");
  check((await page.getByText("not applied").count()) >= 1, "screws are measured and not applied");
  check(await button("Take back…").isDisabled(), "nothing can be taken back before anything moved");

  await button("Apply…").click();
  const dialog = page.getByRole("dialog", { name: "Move the screws?" });
  check(await dialog.getByText(/rises by \d+\.\d{3} mm/).first().isVisible(), "the page says what will move before it does");
  await page.keyboard.press("Escape");
  await dialog.waitFor({ state: "hidden" });
  check(await page.getByText("the screws not moved since").isVisible(), "Escape moves nothing");
  await button("Measure (12 touches)").click();
  await page.getByText("No screw was moved in between").waitFor();
  check(await page.getByText(/does not follow/).count() === 0, "screws that nobody moved are not blamed");
  await button("Apply…").click();
  await button("Move them now").click();
  await page.getByText(/^Done: z1/).waitFor();
  check((await page.getByText("applied", { exact: true }).count()) === 3, "all three screws are applied");

  await button("Take back…").click();
  await button("Take them back now").click();
  await page.getByText("The screws stand as they did when the bed was touched.").waitFor();
  check((await page.getByText("not applied").count()) >= 1, "the screws are back");

  await button("Apply…").click();
  await button("Move them now").click();
  await button("Check it").click();
  await heading("Before and after").waitFor();
  const [before, after] = await rowOf(page, "before", /Most a screw/);
  check(before > 0.1 && after < 0.02, `levelled: ${before} mm before, ${after} mm after`);
  check((await page.getByRole("region", { name: "Measurements, newest first" }).getByRole("row").count()) === 4, "all three measurements are in the history");

  await validates(page, check);
  await button("Touch only at the three screws").click();
  await heading("How flat: not known").waitFor();
  check(true, "three touches tell no flatness");
  await fourCorners(page, check);
  await page.getByText("Write in heights you measured yourself").click();
  await page.getByLabel("Heights: x, y, z").fill("0 0 0\n50 50 0.1\n100 100 0.2");
  await button("Use these heights").click();
  await page.getByRole("alert").filter({ hasText: "span no plane" }).waitFor();
  check(true, "points on one line are refused, and the page says why");
  const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
  check(wide <= 0, "nothing scrolls sideways");
}
