// Drives the pages in Debian's Chromium against a server of its own: run.mjs CALTWIN [PAGE ...].
// Screenshots go to out/pages. Ends with exit code 1 where something that was claimed is not so.
import { spawn } from "node:child_process";
import { mkdirSync, mkdtempSync, readdirSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { createInterface } from "node:readline";
import AxeBuilder from "@axe-core/playwright";
import { chromium } from "playwright-core";

const root = new URL("../../..", import.meta.url).pathname;
const program = resolve(process.argv[2] ?? join(root, "build/caltwin"));
const wanted = process.argv.slice(3);
const shots = join(root, "out/pages");
const options = ["--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking",
  "--disable-component-update", "--disable-sync", "--use-gl=angle", "--use-angle=swiftshader",
  "--enable-unsafe-swiftshader"];

// A server on a free port, or on the port of one before it.
async function serve(state, port = 0) {
  const words = ["serve", "--http", String(port), "--fidelity", "fast", "--state", state];
  const child = spawn(program, words, { stdio: ["ignore", "pipe", "inherit"] });
  for await (const line of createInterface({ input: child.stdout })) {
    const found = /^open (http:\/\/[^ ]+)\//.exec(line);
    if (found) {
      child.stdout.resume();
      return { child, base: found[1], port: Number(found[1].split(":").at(-1)) };
    }
  }
  throw new Error("the server ended before it listened");
}

async function end(child, signal) {
  const ended = new Promise((done) => child.once("exit", done));
  child.kill(signal);
  await ended;
}

// What a page's script has to hand beside the page: the address, claims, pictures, a server that
// is killed and started again.
function tools(name, page, server, faults, state) {
  const check = (holds, what) => {
    console.log(`${holds ? "ok  " : "NOT "} ${name}: ${what}`);
    if (!holds) faults.push(`${name}: ${what}`);
  };
  Object.assign(check, { program, root, shots });
  check.shot = (as) => page.screenshot({ path: join(shots, `${name}-${as}.png`), fullPage: true });
  check.accessible = async (where) => {
    const { violations } = await new AxeBuilder({ page }).analyze();
    for (const one of violations) console.log(`     ${one.id}: ${one.help}: ${one.nodes[0]?.html}`);
    check(violations.length === 0, `axe finds nothing ${where}`);
  };
  // Waits here until `tells` holds of the bench: a promise in page.waitForFunction counts as true.
  check.until = async (tells, pause_ms = 100) => {
    for (const end = Date.now() + 15000; Date.now() < end;) {
      const bench = await fetch(`${server.base}/api/bench`).then((answer) => answer.json(), () => null);
      if (bench && tells(bench)) return bench;
      await new Promise((done) => setTimeout(done, pause_ms));
    }
    throw new Error(`the bench does not get there: ${tells}`);
  };
  check.killAndRestart = async () => {
    await end(server.child, "SIGKILL");
    Object.assign(server, await serve(state, server.port));
  };
  return check;
}

// As the script left it: in light and dark, on a desk and on a phone.
async function look(page, check) {
  for (const scheme of ["light", "dark"]) {
    await page.emulateMedia({ colorScheme: scheme });
    await check.accessible(scheme);
    await check.shot(scheme);
  }
  await page.setViewportSize({ width: 390, height: 844 });
  await page.waitForTimeout(500); // What is drawn to the window's width is drawn again.
  const wide = await page.evaluate(() => document.documentElement.scrollWidth > innerWidth);
  check(!wide, "nothing scrolls sideways on a phone");
  await check.accessible("on a phone");
  await check.shot("phone");
}

async function drive(browser, name, faults) {
  const state = mkdtempSync(join(tmpdir(), "caltwin_e2e_"));
  const server = await serve(state);
  const context = await browser.newContext({ viewport: { width: 1280, height: 900 } });
  const page = await context.newPage();
  page.setDefaultTimeout(30000);
  const start = Date.now();
  const check = tools(name, page, server, faults, state);
  page.on("pageerror", (error) => check(false, `no script error: ${error.message}`));
  try {
    const script = await import(`./${name}.mjs`);
    await script[name](page, server.base, check);
    await look(page, check);
  } catch (error) {
    await check.shot("failed").catch(() => {});
    check(false, `runs to its end: ${error}`);
  }
  console.log(`     ${name}: ${((Date.now() - start) / 1000).toFixed(1)} s`);
  await context.close();
  await end(server.child, "SIGINT");
  rmSync(state, { recursive: true, force: true });
}

mkdirSync(shots, { recursive: true });
const folder = new URL(".", import.meta.url).pathname;
const names = readdirSync(folder).filter((one) => one.endsWith(".mjs") && one !== "run.mjs")
  .map((one) => one.slice(0, -4)).filter((one) => wanted.length === 0 || wanted.includes(one));
const faults = [];
const browser = await chromium.launch({ executablePath: "/usr/bin/chromium", args: options });
// Two at a time, each with its server: a script waits more than it works.
const left = [...names];
const driveLeft = async () => {
  for (let name = left.shift(); name; name = left.shift()) await drive(browser, name, faults);
};
await Promise.all([driveLeft(), driveLeft()]);
await browser.close();
console.log(faults.length === 0 ? `pages: ${names.length} of ${names.length} as claimed`
  : `pages: ${faults.length} claims do not hold`);
process.exit(faults.length === 0 ? 0 : 1);
