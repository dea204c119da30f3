import react from "@vitejs/plugin-react";
import { defineConfig } from "vite";

// Pages end in ../../web, beside models/ and docs/: where `caltwin serve --http` looks.
export default defineConfig({
  plugins: [react()],
  build: { outDir: "../../web", emptyOutDir: true, target: "es2022", chunkSizeWarningLimit: 900 },
  server: { proxy: { "/api": "http://127.0.0.1:8080" } },
});
