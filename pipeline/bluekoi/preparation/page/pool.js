// The pool's size, and its four corners dragged on a frame with the edges fitted after each move.

import { fill } from "./fields.js";
import { FrameView, chosen, line, svg } from "./frame.js";
import { ask, element, numbers, on, setValue, store, tell } from "./store.js";

const KEY = "camera.pool_corners_px";
const NAMES = ["(0,0)", "(L,0)", "(L,W)", "(0,W)"];
// The corners count once all four are placed: until then they stay here.
let view, handles = [], fit = null, history = [], partial = null, busy = false, again = false;
const placed = new Set();
const id = (name) => document.getElementById(name);

function corners() {
  const found = numbers(store.values[KEY] ?? "");
  return Array.isArray(found) && found.length === 4 && found.every((p) => p?.length === 2) ? found : null;
}

function guess() {
  const [w, h] = view.size;
  return [[0.15 * w, 0.85 * h], [0.85 * w, 0.85 * h], [0.85 * w, 0.15 * h], [0.15 * w, 0.15 * h]].map((p) => view.toStudy(p));
}

const text = (points) => `[${points.map((p) => `[${p.map((x) => Number(x.toFixed(2))).join(", ")}]`).join(", ")}]`;

function put(points, remember = true) {
  if (remember && corners()) history.push(store.values[KEY]);
  setValue(KEY, text(points));
}

const shown = () => corners() ?? partial ?? guess();

function draw() {
  const points = shown().map((p) => view.toFrame(p));
  const parts = [];
  const lens = fit?.grid_px?.length > 0;
  if (fit) {
    for (const grid of fit.grid_px) parts.push(line(grid, { stroke: "#35c8e6", "stroke-width": 0.7, opacity: 0.6 }));
    for (const edge of fit.edges_px)
      for (const [u, v] of edge) parts.push(svg("circle", { cx: u + 0.5, cy: v + 0.5, r: view.size[0] / 900, stroke: "#3cdc3c", "stroke-width": 1.5 }));
    for (const p of fit.fitted_px)
      if (p[0] !== null) parts.push(svg("circle", { cx: p[0] + 0.5, cy: p[1] + 0.5, r: view.size[0] / 160, stroke: "#ff3cff", "stroke-width": 2 }));
  }
  const dashed = lens ? { "stroke-dasharray": "6 4", opacity: 0.7 } : {};
  parts.push(line([...points, points[0]], { stroke: "#ff3c3c", "stroke-width": 1.5, ...dashed }));
  view.draw(parts);
}

function table() {
  const points = corners();
  id("pool-table").tBodies[0]?.remove();
  const head = "<tr><th scope=col>Corner</th><th scope=col>u</th><th scope=col>v</th><th scope=col>off by</th><th scope=col>found within</th></tr>";
  if (!id("pool-table").tHead) id("pool-table").createTHead().innerHTML = head;
  const body = id("pool-table").createTBody();
  NAMES.forEach((name, k) => {
    const row = body.insertRow();
    const off = fit?.off_px[k], std = fit?.std_px[k];
    const cells = [name, points?.[k][0].toFixed(1) ?? "–", points?.[k][1].toFixed(1) ?? "–",
      off == null ? "–" : `${off.toFixed(1)} px`, std == null ? "–" : `± ${std.toFixed(1)} px`];
    cells.forEach((cell) => { row.insertCell().textContent = cell; });
  });
}

async function refit() {
  const said = id("pool-fit");
  table();
  if (!corners() && !placed.size) {
    said.className = "";
    said.textContent = "Drag the four circles (or move them with the arrow keys) to the corners of the pool. They stay in the order (0,0), (L,0), (L,W), (0,W), counter-clockwise; any corner may be (0,0) if the next one lies along the pool's length.";
    forget();
    draw();
    return;
  }
  if (!store.values["pool.length_m"] || !store.values["pool.width_m"]) {
    said.className = "bad";
    said.textContent = "Enter the pool's length and width above: then the edges are fitted.";
    return;
  }
  const open = NAMES.filter((_, k) => !placed.has(k));
  said.className = "";
  if (open.length) {
    said.textContent = `Now drag ${open.join(", ")}.`;
    forget();
    return;
  }
  said.textContent = "Fitting the edges …";
  id("pool-use").disabled = true;
  // One fit at a time: what has moved meanwhile is fitted after it.
  again = busy;
  if (busy) return;
  busy = true;
  try {
    const row = store.rows.find((one) => one.source === chosen.source);
    const found = await ask("corners", { values: store.values, source: chosen.source, share: chosen.share, fps: row?.fps ?? "" });
    if (again) return;
    fit = found;
    verdict();
  } catch (error) {
    if (again) return;
    forget();
    said.className = "bad";
    said.textContent = error.message;
  } finally {
    busy = false;
    if (again) { again = false; refit(); }
  }
  table();
  draw();
}

function forget() {
  fit = null;
  store.fit = null;
  tell("findings");
}

function verdict() {
  store.fit = fit;
  tell("findings");
  id("pool-use").classList.remove("main");
  const said = id("pool-fit"), off = Math.max(...fit.off_px.map((x) => x ?? 0));
  const whole = fit.suggested_px.every((p) => p[0] !== null);
  said.className = fit.confirmed ? "good" : "bad";
  if (fit.confirmed) said.textContent = `The edges confirm these corners (off by ${off.toFixed(1)} px at most).`;
  else if (whole && !fit.doubts.length) {
    said.className = "next";
    id("pool-use").classList.add("main");
    said.textContent = `The edges were found; they meet ${off.toFixed(1)} px from the farthest corner given. Do the magenta circles sit on the pool's corners? Then press "Use the fitted corners".`;
  }
  else said.textContent = `The edges are not certain: ${fit.doubts.join("; ") || "see below"}. Trust your eyes, with the magnifier.`;
  id("pool-use").disabled = !whole;
  id("pool-inner").hidden = fit.inner_rim_px.some((p) => p[0] === null);
  id("pool-sentences").replaceChildren(...fit.sentences.map((one) => element("li", { textContent: one })));
}

export function start() {
  fill("pool-fields", ["pool.length_m", "pool.width_m", "pool.depth_m", "camera.pool_corners_height_m"]);
  view = new FrameView("pool-frame", { onPicture: () => { place(); refit(); } });
  id("pool-use").onclick = () => { put(fit.suggested_px); place(); refit(); };
  id("pool-inner").onclick = () => { put(fit.inner_rim_px.map((p) => view.toStudy(p))); place(); refit(); };
  id("pool-turn").onclick = () => {
    const [first, second, third, fourth] = shown(), next = [fourth, first, second, third];
    if (corners()) put(next);
    else partial = next;
    const turned = [...placed].map((k) => (k + 1) % 4);
    placed.clear();
    turned.forEach((k) => placed.add(k));
    place();
    refit();
  };
  id("pool-undo").onclick = () => {
    if (!history.length) return;
    setValue(KEY, history.pop());
    NAMES.forEach((_, k) => placed.add(k));
    place();
    refit();
  };
  id("pool-use").disabled = true;
  let waiting;
  on("value", (key) => {
    if (id("pool").hidden || !/^(pool|water)\.|corners_height/.test(key)) return;
    clearTimeout(waiting);
    waiting = setTimeout(refit, 700);
  });
}

function place() {
  if (!view.size[0]) return;
  const points = shown();
  if (!handles.length && corners()) NAMES.forEach((_, k) => placed.add(k));
  const before = document.activeElement;
  if (!handles.length) handles = NAMES.map((name, k) => view.handle(`Corner ${name}`, view.toFrame(points[k]), {
    moved: (at) => {
      const all = shown();
      all[k] = view.toStudy(at);
      placed.add(k);
      if (placed.size === NAMES.length) setValue(KEY, text(all));
      else partial = all;
      draw();
      table();
    },
    ended: () => refit(),
  }));
  handles.forEach((handle, k) => handle.set(view.toFrame(points[k])));
  handles.forEach((handle) => handle.button.addEventListener("pointerdown", () => { if (corners()) history.push(store.values[KEY]); }, { once: true }));
  before?.focus?.({ preventScroll: true });
  draw();
}

export const show = () => view.show();
