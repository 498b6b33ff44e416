// The calibration: from a file, computed from pictures of a board, or none.

import { fill } from "./fields.js";
import { ask, element, numbers, on, setValue, store, tell } from "./store.js";

const LENS = ["camera.model", "camera.image_size_px", "camera.matrix", "camera.distortion"];
const id = (name) => document.getElementById(name);

function said(text, good = true) {
  id("camera-job").className = good ? "" : "bad";
  id("camera-job").textContent = text;
}

function shownState() {
  const size = numbers(store.values["camera.image_size_px"] ?? "");
  const wrong = store.findings.some((one) => LENS.includes(one.key));
  const error = store.fit?.sentences.find((one) => one.includes("distortion"));
  id("camera-state").textContent = !store.values["camera.matrix"]
    ? `No calibration: the pool's corners alone map the picture (homography)${error ? `; ${error}` : ""}.`
    : wrong ? "The calibration is not complete: see the numbers below."
      : `Calibrated: ${store.values["camera.model"] ?? "pinhole"} lens, pictures of ${Array.isArray(size) ? size.join(" x ") : "unknown"} px.`;
  if (wrong) id("camera-numbers").open = true;
  id("camera-drop").disabled = !store.values["camera.matrix"];
  id("camera-files").replaceChildren(...(store.files.cameras ?? []).map((value) => element("option", { value })));
}

async function compute(files) {
  said("Computing …");
  try {
    await ask("calibrate", { files, pattern: id("board-pattern").value, square_mm: Number(id("board-square").value) });
    for (;;) {
      await new Promise((done) => { setTimeout(done, 500); });
      const job = await ask("job?name=calibration");
      if (job.state === "failed") throw new Error(job.error);
      if (job.state !== "done") continue;
      for (const key of LENS) setValue(key, job.result.values[key] ?? "");
      tell("reload");
      said(job.result.remarks.join("; "));
      return;
    }
  } catch (error) {
    said(error.message, false);
  }
}

export function start() {
  fill("camera-fields", LENS);
  fill("water-fields", ["water.refractive_index", "water.density_kg_m3"]);
  id("camera-take").onclick = () => compute(id("camera-file").value);
  id("board-compute").onclick = () => compute(id("board-files").value);
  id("camera-drop").onclick = () => {
    for (const key of LENS) setValue(key, "");
    said("The calibration was taken out; nothing is saved yet.");
  };
  on("value", shownState);
  on("reload", shownState);
  on("findings", shownState);
}

export function show() {
  const files = store.files.cameras ?? [];
  if (!id("camera-file").value && files.length === 1) [id("camera-file").value] = files;
  shownState();
}
