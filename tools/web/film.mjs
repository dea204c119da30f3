// A film of a run's playback: film.mjs REPORT/index.html OUT.webm FROM SECONDS. Plays the report
// from the given part of the run (0 to 1) in Chromium and records what its canvas shows.
import { writeFileSync } from "node:fs";
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { chromium } from "playwright-core";

const [report, out, from, seconds] = process.argv.slice(2);
if (!seconds) {
  console.error("film.mjs REPORT/index.html OUT.webm FROM SECONDS");
  process.exit(2);
}

// In the page: the canvas as WebM, base64.
const record = (canvas, ms) => new Promise((done, fail) => {
  const recorder = new MediaRecorder(canvas.captureStream(15), { mimeType: "video/webm;codecs=vp9", videoBitsPerSecond: 350_000 });
  const parts = [];
  recorder.ondataavailable = (event) => parts.push(event.data);
  recorder.onerror = fail;
  recorder.onstop = async () => {
    const reader = new FileReader();
    reader.onload = () => done(reader.result.split(",")[1]);
    reader.readAsDataURL(new Blob(parts));
  };
  recorder.start();
  setTimeout(() => recorder.stop(), ms);
});

const browser = await chromium.launch({
  executablePath: "/usr/bin/chromium",
  args: ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
});
try {
  const page = await browser.newPage({ viewport: { width: 760, height: 900 }, colorScheme: "light" });
  await page.goto(pathToFileURL(resolve(report)).href);
  await page.locator("canvas[data-drawn]").waitFor();
  const where = page.getByLabel(/Where in the run/);
  await where.fill(String(Math.round(Number(await where.getAttribute("max")) * Number(from))));
  await page.getByRole("button", { name: "Play", exact: true }).click();
  const film = await page.locator("canvas[data-drawn]").evaluate(record, Number(seconds) * 1000);
  writeFileSync(out, Buffer.from(film, "base64"));
} finally {
  await browser.close();
}
