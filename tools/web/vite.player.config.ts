import react from "@vitejs/plugin-react";
import { defineConfig } from "vite";

// One script with its styles inside, web/player.js: a report of a run carries it
// (renders/playback).
export default defineConfig({
  plugins: [react()],
  define: { "process.env.NODE_ENV": '"production"' },
  build: {
    outDir: "../../web", emptyOutDir: false, target: "es2022", chunkSizeWarningLimit: 900,
    // light-dark() stays as it is: what it would become needs a :root, which the player's has not.
    cssTarget: ["chrome123", "firefox120", "safari17.5"],
    lib: { entry: "src/player/main.tsx", formats: ["iife"], name: "caltwinPlayer", fileName: () => "player.js" },
  },
});
