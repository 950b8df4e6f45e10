import react from "@vitejs/plugin-react";
import { defineConfig } from "vite";

const source = (path: string): string => `${import.meta.dirname}/src/${path}`;

export default defineConfig({
  plugins: [react()],
  resolve: {
    // Those of h5web's make their code from texts, which the content-security policy forbids.
    alias: { ndarray: source("viewer/ndarray.ts"), "ndarray-ops": source("viewer/ndarrayOps.ts") },
  },
  build: {
    outDir: "../static",
    emptyOutDir: true,
    license: { fileName: "LICENCES.md" },
    // The HDF5 viewer with its three.js is one chunk of this size, loaded only when a file is looked into.
    chunkSizeWarningLimit: 1400,
  },
  server: { proxy: { "/api": "http://127.0.0.1:8765", "/h5": "http://127.0.0.1:8765" } },
});
