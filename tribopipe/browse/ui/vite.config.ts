import react from "@vitejs/plugin-react";
import { defineConfig } from "vite";

export default defineConfig({
  plugins: [react()],
  build: { outDir: "../static", emptyOutDir: true, license: true },
  server: { proxy: { "/api": "http://127.0.0.1:8765", "/h5": "http://127.0.0.1:8765" } },
});
