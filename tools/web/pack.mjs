// Packs what was built, so that the server need not: FILE.gz beside FILE.
import { readdirSync, readFileSync, statSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { gzipSync } from "node:zlib";

const root = new URL("../../web", import.meta.url).pathname;

function pack(folder) {
  let script = 0;
  for (const name of readdirSync(folder)) {
    const path = join(folder, name);
    if (statSync(path).isDirectory()) script += pack(path);
    else if (/\.(js|css|html|svg|json)$/.test(name)) {
      const packed = gzipSync(readFileSync(path), { level: 9 });
      writeFileSync(`${path}.gz`, packed);
      // A report carries the player, no page loads it.
      if (name.endsWith(".js") && name !== "player.js") script += packed.length;
    }
  }
  return script;
}

console.log(`pages: ${Math.round(pack(root) / 1000)} kB of script, packed`);
