// The robot's dimensions beside a drawing of them, and its outline to scale over a frame.

import { fill, label } from "./fields.js";
import { FrameView, chosen, line, svg } from "./frame.js";
import { ask, on, store } from "./store.js";

const KEYS = ["body_length_m", "head_length_m", "head_span_m", "hinge_to_com_m", "tail_length_m",
  "mass_kg", "yaw_inertia_kg_m2", "keypoint_depth_m"].map((name) => `robot.${name}`);
const id = (name) => document.getElementById(name);
let view, com, toward, waiting, asked = 0;

function ready() {
  return ["robot.body_length_m", "robot.head_length_m", "robot.hinge_to_com_m", "robot.tail_length_m",
    "camera.pool_corners_px", "pool.length_m", "pool.width_m"].filter((key) => !store.values[key]);
}

async function outline() {
  const missing = ready();
  if (missing.length) {
    id("robot-said").className = "bad";
    id("robot-said").textContent = `The outline needs: ${missing.map(label).join(", ")}.`;
    view.draw();
    return;
  }
  if (!com) return;
  const [x_px, y_px] = view.toStudy(com.point), [toward_x_px, toward_y_px] = view.toStudy(toward.point);
  const count = ++asked;
  try {
    const values = { ...store.values };
    for (const key of ["robot.mass_kg", "robot.yaw_inertia_kg_m2", "robot.head_span_m"]) values[key] ??= "0.001";
    const found = await ask("outline", { values, place: { x_px, y_px, toward_x_px, toward_y_px,
      head_angle_deg: Number(id("robot-angle").value) || 0, head_length_m: Number(id("robot-head").value) || 0 } });
    if (count !== asked) return;
    draw(found);
    const seen = Math.hypot(found.head[0][0] - found.core[1][0], found.head[0][1] - found.core[1][1]) * view.scale();
    id("robot-said").className = "";
    id("robot-said").textContent = `Nose to caudal base: ${seen.toFixed(0)} px in this frame; `
      + `centre of mass at (${x_px.toFixed(0)}, ${y_px.toFixed(0)}) px.`
      + (seen < 40 ? " Detection needs 40 px or more." : "");
  } catch (error) {
    id("robot-said").className = "bad";
    id("robot-said").textContent = error.message;
  }
}

function draw(found) {
  const px = (points) => points.map((p) => view.toFrame(p));
  const dot = ([u, v], stroke) => svg("circle", { cx: u + 0.5, cy: v + 0.5, r: view.size[0] / 300, stroke, "stroke-width": 2 });
  const head = px(found.head), core = px(found.core), tail = px(found.tail);
  const style = (stroke) => ({ stroke, "stroke-width": 3, opacity: 0.9 });
  view.draw(line(tail, style("#b9f5b0")), line(core, style("#ffd23c")), line(head, style("#35c8e6")),
    dot(head[0], "#35c8e6"), dot(core[0], "#fff"), dot(core[1], "#ffd23c"), dot(tail[1], "#b9f5b0"));
}

function place() {
  if (!view.size[0]) return;
  const [w, h] = view.size;
  const moved = () => { clearTimeout(waiting); waiting = setTimeout(outline, 60); };
  if (!com) {
    com = view.handle("Centre of mass", [w / 2, h / 2], { moved, ended: moved });
    toward = view.handle("Nose side", [w / 2 + w / 8, h / 2], { square: true, moved, ended: moved });
  }
  outline();
}

function shown() {
  const row = store.rows.find((one) => one.source === chosen.source);
  id("robot-angle").value = row?.head_angle_deg || "0";
  id("robot-head").value = row?.head_length_m || store.values["robot.head_length_m"] || "";
}

// The outline where the preview found the robot in this very frame.
function detected() {
  const row = store.rows.find((one) => one.source === chosen.source);
  const found = store.previews.get(row?.trial_id);
  if (!found) {
    id("robot-said").textContent = "Preview this video first (step Preview): then the outline can be placed on what was found.";
    return;
  }
  if (found.consecutive) {
    id("robot-said").textContent = "This video was previewed on its first frames; place the outline by hand.";
    return;
  }
  const k = Math.round(chosen.share * (found.frames - 1));
  const at = (name) => found.xy_px[k][found.names.indexOf(name)];
  const [center, hinge] = [at("core_center"), at("hinge")];
  if (center[0] === null || hinge[0] === null) {
    id("robot-said").textContent = "The robot was not found in this frame; choose another one.";
    return;
  }
  com.set(center);
  toward.set([center[0] + 3 * (hinge[0] - center[0]), center[1] + 3 * (hinge[1] - center[1])]);
  outline();
}

function placeable() {
  const row = store.rows.find((one) => one.source === chosen.source);
  id("robot-place").disabled = !store.previews.get(row?.trial_id);
}

export function start() {
  fill("robot-fields", KEYS);
  fill("detection-fields", ["detection.source", "detection.body", "detection.marker_hues_deg"]);
  fetch("page/robot.svg").then((answer) => answer.text()).then((text) => { id("robot-drawing").innerHTML = text; });
  view = new FrameView("robot-frame", { onPicture: () => { shown(); place(); placeable(); } });
  for (const name of ["robot-angle", "robot-head"]) id(name).addEventListener("input", outline);
  id("robot-place").onclick = detected;
  on("focus", (key) => {
    for (const part of id("robot-drawing").querySelectorAll("[data-key]"))
      for (const one of part.querySelectorAll(".dim, text")) one.classList.toggle("chosen", part.dataset.key === key);
  });
  on("value", (key) => {
    if (id("robot").hidden || !key.startsWith("robot.")) return;
    if (key === "robot.head_length_m") id("robot-head").value = store.values[key] ?? "";
    clearTimeout(waiting);
    waiting = setTimeout(outline, 300);
  });
}

export const show = () => view.show();
