// The detection on twenty frames of each video, with the reason where it fails.

import { FrameView, chosen, line, svg } from "./frame.js";
import { ask, draft, element, on, store, tell } from "./store.js";

const id = (name) => document.getElementById(name);
let view, stopped = true, selected = "";
const errors = store.previewErrors;

const filmed = () => store.rows.filter((row) => row.trial_id && row.source && !/\.(csv|h5|hdf5|slp)$/i.test(row.source));

function dots(found) {
  return element("span", { className: "dots", "aria-hidden": "true" },
    ...found.likelihood.map((p, k) => element("i", { className: p >= 0.6 ? "yes" : p > 0 ? "weak" : "",
      title: `frame ${k + 1}: likelihood ${p}`, "data-share": k / Math.max(found.frames - 1, 1) })));
}

function list() {
  id("preview-list").replaceChildren(...filmed().map((row) => {
    const found = store.previews.get(row.trial_id), error = errors.get(row.trial_id);
    const state = found ? `${found.found} of ${found.frames} frames ` : error ? "not previewed " : "– ";
    const remarks = error ? [error] : found?.remarks ?? [];
    const button = element("button", { className: "trial" }, element("strong", { textContent: row.trial_id }), state,
      ...(found ? [dots(found)] : []), ...remarks.map((text) => element("span", { className: "remarks", textContent: text })));
    button.setAttribute("aria-pressed", String(row.trial_id === selected));
    button.onclick = ({ target }) => {
      if (target.dataset.share) chosen.share = Number(target.dataset.share);
      pick(row);
    };
    return button;
  }));
  if (!filmed().length) id("preview-list").textContent = "No trial with a video yet: see Trials.";
}

async function pick(row) {
  selected = row.trial_id;
  list();
  view.show(row.source, chosen.share);
  if (!store.previews.has(selected)) await one(row);
}

async function one(row) {
  id("preview-said").textContent = `Detecting in ${row.trial_id} …`;
  errors.delete(row.trial_id);
  try {
    await ask("preview", { ...draft(), trial_id: row.trial_id });
    for (;;) {
      await new Promise((done) => { setTimeout(done, 250); });
      const job = await ask(`job?name=${encodeURIComponent(`preview ${row.trial_id}`)}`);
      if (job.state === "failed") throw new Error(job.error);
      if (job.state === "absent") throw new Error("stopped");
      if (job.state === "done") { store.previews.set(row.trial_id, job.result); break; }
    }
  } catch (error) {
    errors.set(row.trial_id, error.message);
  }
  id("preview-said").textContent = "";
  tell("findings");
  list();
  draw();
}

async function all() {
  stopped = false;
  const rows = filmed();
  store.previews.clear();
  errors.clear();
  list();
  for (const [k, row] of rows.entries()) {
    if (stopped) break;
    if (!selected || k === 0) { selected = row.trial_id; view.show(row.source, chosen.share); }
    await one(row);
    id("preview-said").textContent = `${k + 1} of ${rows.length} videos`;
  }
  const good = rows.filter((row) => { const f = store.previews.get(row.trial_id); return f && f.found >= 0.9 * f.frames; }).length;
  id("preview-said").textContent = stopped ? "Stopped." : `The robot is found in nine of ten frames or more of ${good} of ${rows.length} videos.`;
  stopped = true;
}

function draw() {
  const row = store.rows.find((one) => one.source === chosen.source);
  const found = store.previews.get(row?.trial_id);
  if (!found || !view.size[0]) { view.draw(); id("preview-about").textContent = found ? "" : "Not previewed yet."; return; }
  const k = Math.min(Math.round(chosen.share * (found.frames - 1)), found.frames - 1);
  const points = found.xy_px[k], colours = ["#35c8e6", "#ffffff", "#ffd23c", "#ffb03c", "#b9f5b0"];
  const parts = [line(points, { stroke: "#ff3c3c", "stroke-width": 1.5 })];
  points.forEach((p, i) => { if (p[0] !== null) parts.push(svg("circle", { cx: p[0] + 0.5, cy: p[1] + 0.5, r: view.size[0] / 250, stroke: colours[i % 5], "stroke-width": 2 })); });
  view.draw(parts);
  const doubt = found.likelihood[k] < 0.6 ? ": doubtful, left out of the analysis" : "";
  const said = points.some((p) => p[0] !== null) ? `likelihood ${found.likelihood[k]}${doubt}` : "not found";
  id("preview-about").textContent = `Frame ${k + 1} of ${found.frames} (${found.time_s[k].toFixed(2)} s): ${said}. ${found.names.join(", ")} from nose to tail.${found.consecutive ? " The first frames, since start_x_px names one of several bodies." : ""}`;
}

export function start() {
  const first = (row) => (row?.start_x_px ? { first: Number(row.start_s) || 0 } : {});
  view = new FrameView("preview-frame", { onPicture: draw, more: first });
  id("preview-all").onclick = () => { if (stopped) all(); };
  id("preview-stop").onclick = () => { stopped = true; };
  // What was seen with other values says nothing about these.
  on("value", () => { store.previews.clear(); errors.clear(); });
}

export function show() {
  if (!filmed().some((row) => row.trial_id === selected)) selected = "";
  list();
  view.show();
}
