// The robot's dimensions beside a drawing of them, and its outline to scale over a frame.

import { fill, label } from "./fields.js";
import { FrameView, chosen, line, svg } from "./frame.js";
import { ask, on, store } from "./store.js";

const KEYS = ["body_length_m", "head_length_m", "head_span_m", "hinge_to_com_m", "tail_length_m",
  "mass_kg", "yaw_inertia_kg_m2", "keypoint_depth_m"].map((name) => `robot.${name}`);
const id = (name) => document.getElementById(name);
let view, com, toward, waiting, asked = 0;

// Top view with the nose to the right, a side view of the head, and the sign of the head angle.
const DRAWING = `<svg class="drawing" viewBox="0 0 640 400" role="img" aria-label="Robot seen from above, nose to the right: body length from nose to caudal base, head length from nose to hinge, centre of mass behind the hinge, tail behind the caudal base. Positive head angle: the head points to the robot's right seen from above.">
<text x="8" y="18">From above, nose to the right</text>
<path d="M600 110 Q540 84 420 90 L420 130 Q540 136 600 110Z" fill="#cfe3f1" stroke="#1c2630"/>
<path d="M412 88 Q260 84 130 102 L130 118 Q260 136 412 132Z" fill="#e6ecf0" stroke="#1c2630"/>
<path d="M130 110 L40 92 L52 110 L40 128Z" fill="#f3f7f9" stroke="#1c2630"/>
<circle cx="416" cy="110" r="5" fill="#1c2630"/><text x="424" y="80">hinge</text>
<circle cx="356" cy="110" r="7" fill="#fff" stroke="#1c2630"/><path d="M356 103v14M349 110h14" stroke="#1c2630"/><text x="310" y="78">centre of mass</text>
<text x="96" y="82">caudal base</text><text x="2" y="84">tail tip</text><text x="604" y="102">nose</text>
<g data-key="robot.head_length_m"><path class="dim" d="M416 150H600M416 143v14M600 143v14"/><text x="470" y="167">head length</text></g>
<g data-key="robot.hinge_to_com_m"><path class="dim" d="M356 150H416M356 143v14"/><text x="252" y="167">hinge to centre of mass</text></g>
<g data-key="robot.tail_length_m"><path class="dim" d="M40 150H130M40 143v14M130 143v14"/><text x="40" y="167">tail length</text></g>
<g data-key="robot.body_length_m"><path class="dim" d="M130 190H600M130 183v14M600 183v14"/><text x="310" y="207">body length</text></g>
<text x="8" y="240">From the side</text>
<path d="M20 258 q14 -8 28 0 t28 0 t28 0 t28 0 t28 0 t28 0 t28 0" fill="none" stroke="#0072b2"/>
<rect x="120" y="290" width="80" height="60" fill="#cfe3f1" stroke="#1c2630"/><rect x="40" y="310" width="80" height="20" fill="#e6ecf0" stroke="#1c2630"/>
<g data-key="robot.head_span_m"><path class="dim" d="M212 290V350M205 290h14M205 350h14"/><text x="180" y="368">head span</text></g>
<g data-key="robot.keypoint_depth_m"><path class="dim" d="M70 258V300M63 258h14M63 300h14"/><text x="8" y="368">depth of the keypoints</text><circle cx="70" cy="302" r="3" fill="#1c2630"/></g>
<text x="320" y="240">Head angle, seen from above</text>
<path d="M500 300 H360" stroke="#1c2630" stroke-width="6"/><path d="M500 300 L590 352" stroke="#0072b2" stroke-width="8"/>
<path class="dim" d="M500 300H610" stroke-dasharray="5 4"/><path d="M572 300 A72 72 0 0 1 562 336" fill="none" stroke="#b34700" stroke-width="2"/>
<text x="398" y="290">core</text><text x="548" y="372">head</text><text x="578" y="324">+ angle</text>
<text x="320" y="388">positive: head to the robot's right</text>
</svg>`;

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

export function start() {
  fill("robot-fields", KEYS);
  fill("detection-fields", ["detection.source", "detection.body", "detection.marker_hues_deg"]);
  id("robot-drawing").innerHTML = DRAWING;
  view = new FrameView("robot-frame", { onPicture: () => { shown(); place(); } });
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
