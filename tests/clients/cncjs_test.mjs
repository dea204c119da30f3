// cncjs, as it ships and headless, on `caltwin serve --dialect grbl`: it recognises the
// controller, homes, probes the block, sets a work offset, runs a job to its end, pauses and
// resumes it.
//
//     cncjs_test.mjs FOLDER_OF_NODE_MODULES TERMINAL
import { spawn } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { createServer } from "node:net";
import { tmpdir } from "node:os";
import { join } from "node:path";

const [modules, terminal] = process.argv.slice(2);
const require = createRequire(join(modules, "node_modules/cncjs/package.json"));
const io = require("socket.io-client");
const jwt = require("jsonwebtoken");

const secret = "of this test";
const folder = mkdtempSync(join(tmpdir(), "cncjs-"));
const config = join(folder, "cncrc");
writeFileSync(config, JSON.stringify({
  secret,
  state: { checkForUpdates: false, allowAnonymousUsageDataCollection: false },
}));

const freePort = () => new Promise((done) => {
  const server = createServer().listen(0, "127.0.0.1", () => {
    const { port } = server.address();
    server.close(() => done(port));
  });
});

const wait = async (what, isSo, patience_ms = 10000) => {
  const end = Date.now() + patience_ms;
  while (Date.now() < end) {
    const answer = isSo();
    if (answer) return answer;
    await new Promise((done) => setTimeout(done, 20));
  }
  throw new Error(`waited ${patience_ms} ms for ${what}; read ${JSON.stringify(read.slice(-12))}`);
};

const read = [];
let state = {};
let sender = {};
let workflow = "";

const connect = (port) => new Promise((done, fail) => {
  const token = jwt.sign({ id: "", name: "" }, secret, { expiresIn: "1h" });
  const socket = io(`http://127.0.0.1:${port}`, { query: `token=${token}`, reconnection: true });
  socket.on("startup", () => done(socket));
  socket.on("error", fail);
});

const job = () => {
  const lines = ["G21 G90", "G53 G0 Z-10", "F2400"];
  for (let k = 0; k < 300; ++k) {
    lines.push(`G1 X${(k % 2) * 30} Y${(k / 10).toFixed(3)}`);
  }
  lines.push("G3 X10 Y29.9 I-10 J0", "M30");
  return lines.join("\n");
};

const run = async (cncjs) => {
  const port = cncjs.port;
  let socket = null;
  await wait("the server", () => cncjs.said.includes("Starting the server at"), 60000);
  socket = await connect(port);
  socket.on("serialport:read", (line) => read.push(line));
  socket.on("controller:state", (_type, next) => { state = next; });
  socket.on("sender:status", (next) => { sender = next; });
  socket.on("workflow:state", (next) => { workflow = next; });
  const opened = new Promise((done, fail) => {
    socket.emit("open", terminal, { controllerType: "Grbl", baudrate: 115200 },
      (error) => (error ? fail(new Error(error)) : done()));
  });
  await opened;
  const command = (...words) => socket.emit("command", terminal, ...words);
  const active = () => state?.status?.activeState;
  const place = () => state?.status?.mpos ?? {};

  await wait("the greeting", () => read.some((line) => line.startsWith("Grbl 1.1h")));
  await wait("an alarm: it is not homed", () => active() === "Alarm");
  command("homing");
  await wait("home", () => active() === "Idle" && Number(place().z) === -2);
  command("gcode", ["G53 G0 X-150 Y-150", "G38.2 Z-110 F60"]);
  const probed = await wait("the probe", () => read.find((line) => line.startsWith("[PRB:")));
  const z = Number(probed.split(",")[2].split(":")[0]);
  const wanted = 25.4 + 1 - 0.02 - 120;
  if (Math.abs(z - wanted) > 0.0013) throw new Error(`probed ${z} where ${wanted} is`);
  console.log(`block's top by G38.2, machine z [mm]: ${z}`);
  command("gcode", ["G10 L20 P1 X0 Y0 Z0", "G53 G0 Z-2"]);
  await wait("the work offset", () => Number(state?.status?.wco?.x) === -150);

  socket.emit("command", terminal, "gcode:load", "job.nc", job(), {}, () => {});
  await wait("the job", () => sender.total > 0);
  command("gcode:start");
  await wait("its first lines", () => sender.received > 20);
  command("gcode:pause");
  await wait("the pause", () => workflow === "paused" && active() === "Hold");
  command("gcode:resume");
  await wait("its end", () => sender.total > 0 && sender.received === sender.total, 20000);
  await wait("Idle", () => active() === "Idle" && Math.abs(Number(place().x) + 140) < 0.002);
  const errors = read.filter((line) => /error:/.test(line));
  if (errors.length > 0) throw new Error(`errors: ${errors}`);
  console.log(`job of ${sender.total} lines, paused and resumed: done`);
  socket.emit("close", terminal, () => {});
  socket.disconnect();
};

const port = await freePort();
const program = spawn(process.execPath, [join(modules, "node_modules/cncjs/bin/cncjs"),
  "--host", "127.0.0.1", "--port", String(port), "--config", config],
{ env: { ...process.env, HOME: folder } });
const cncjs = { port, said: "" };
for (const stream of [program.stdout, program.stderr]) {
  stream.on("data", (bytes) => { cncjs.said += bytes; });
}
let code = 0;
try {
  await run(cncjs);
} catch (error) {
  console.error(String(error), "\ncncjs said:", cncjs.said.slice(-800));
  code = 1;
}
program.kill("SIGTERM");
rmSync(folder, { recursive: true, force: true });
process.exit(code);
