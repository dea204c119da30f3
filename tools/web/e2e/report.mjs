// The report of a run, opened as a file without a network: it plays the run back by itself.
import { execFileSync } from "node:child_process";
import { mkdtempSync, rmSync, statSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { pathToFileURL } from "node:url";

const mostBytes = 2_000_000;

const looks = (page) => page.locator(".mac-view").screenshot().then((png) => png.toString("base64"));

function write(check, scenario, folder) {
  try {
    execFileSync(check.program, ["run", join(check.root, "scenarios", `${scenario}.yaml`), "--fidelity", "fast", "--report", folder], { stdio: "ignore" });
  } catch (fault) {
    if (fault.status !== 1) throw fault; // A check of the scenario's own that fails.
  }
  const bytes = statSync(join(folder, "index.html")).size;
  check(bytes < mostBytes, `the report of ${scenario} is small: ${Math.round(bytes / 1000)} kB`);
  return pathToFileURL(join(folder, "index.html")).href;
}

async function plays(page, check) {
  const where = page.getByLabel(/Where in the run/);
  const now = page.locator(".mac-now");
  const first = await looks(page);
  const third = Math.round(Number(await where.getAttribute("max")) / 3);
  await where.fill(String(third));
  await page.waitForTimeout(500);
  check((await looks(page)) !== first, "the slider moves the machine");
  check((await page.locator("li[aria-current]").innerText()).includes(await now.locator("code").innerText()), "the list marks the same line");
  const before = await looks(page);
  await page.getByRole("button", { name: "Play", exact: true }).focus();
  await page.keyboard.press("Enter");
  await page.waitForTimeout(1500);
  await page.getByRole("button", { name: "Pause" }).click();
  check(Number(await where.inputValue()) > third, "Play goes on from there, by keyboard");
  check((await looks(page)) !== before, "the machine has moved");
  await page.getByRole("application").focus();
  const unturned = await looks(page);
  await page.keyboard.press("ArrowLeft");
  await page.waitForTimeout(300);
  check((await looks(page)) !== unturned, "an arrow key turns it");
}

// Pixels in the colour of the dots: the canvas is drawn again and read before it is shown.
async function dots(page) {
  const png = await page.locator(".mac-view canvas").screenshot();
  return page.evaluate(async (bytes) => {
    const image = await createImageBitmap(new Blob([Uint8Array.from(atob(bytes), (c) => c.charCodeAt(0))]));
    const canvas = new OffscreenCanvas(image.width, image.height).getContext("2d");
    canvas.drawImage(image, 0, 0);
    const { data } = canvas.getImageData(0, 0, image.width, image.height);
    let count = 0;
    for (let i = 0; i < data.length; i += 4) {
      if (data[i] > 215 && data[i + 1] > 70 && data[i + 1] < 110 && data[i + 2] < 40) count++;
    }
    return count;
  }, png.toString("base64"));
}

async function enlarges(page, check) {
  const built = await looks(page);
  await page.getByLabel(/Errors drawn \d+ times as large/).check();
  await page.waitForTimeout(500);
  check((await looks(page)) !== built, "errors drawn larger change the drawing");
}

async function prints(page, check) {
  await page.emulateMedia({ media: "print" });
  check(await page.getByText("On a screen, in a browser with JavaScript").isVisible(), "on paper a line says that there is a playback");
  check(!(await page.getByRole("button", { name: "Play", exact: true }).isVisible()), "and the player does not print");
  await page.emulateMedia({ media: "screen" });
}

async function open(page, check, scenario, folder) {
  await page.goto(write(check, scenario, folder));
  await page.locator("canvas[data-drawn]").waitFor();
}

export async function report(page, _base, check) {
  const folder = mkdtempSync(join(tmpdir(), "caltwin_report_"));
  const asked = [];
  page.on("request", (request) => { if (!/^(file|data|blob):/.test(request.url())) asked.push(request.url()); });
  page.on("console", (message) => { if (message.type() === "error") check(false, `no error: ${message.text()}`); });
  await page.context().setOffline(true);
  try {
    for (const scenario of ["delta_joint_recovers", "tz_levels_in_one_round", "first_light"]) {
      await open(page, check, scenario, folder);
      await plays(page, check);
      await page.getByLabel(/Where in the run/).fill("0");
      await page.waitForTimeout(400);
      const none = await dots(page);
      await page.getByLabel(/Where in the run/).press("End");
      await page.waitForTimeout(800);
      check((await dots(page)) > none + 20, `dots are left where it touched`);
      await page.locator("#playback-player").screenshot({ path: join(check.shots, `report-${scenario}.png`) });
      await enlarges(page, check);
      await page.locator("#playback-player").screenshot({ path: join(check.shots, `report-${scenario}-enlarged.png`) });
    }
    await prints(page, check);
    check(asked.length === 0, `nothing is asked for elsewhere: ${asked}`);
    await page.goto(write(check, "motor_stepper_home", folder));
    check((await page.locator("#playback-player").count()) === 0, "motors without a tip are not played");
    await open(page, check, "corexy_by_dials", folder);
  } finally {
    rmSync(folder, { recursive: true, force: true });
  }
}
