// The player of a report: it is given a run by the page and loads nothing.
import { createRoot } from "react-dom/client";
import machine from "../machine/machine.css?inline";
import controls from "../style.css?inline";
import own from "./player.css?inline";
import { Player, type Playback } from "./player";

const host = document.getElementById("playback-player");
const playback = document.getElementById("playback-data")?.textContent;
if (host && playback) {
  const root = host.attachShadow({ mode: "open" });
  const style = document.createElement("style");
  style.textContent = controls + machine + own;
  const place = document.createElement("div");
  // What the page says without the player, for paper.
  root.append(style, place, document.createElement("slot"));
  createRoot(place).render(<Player playback={JSON.parse(playback) as Playback} />);
}
