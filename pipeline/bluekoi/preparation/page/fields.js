// Input fields of study.yaml's keys, each with its meaning, and its errors beside it.

import { element, on, setValue, store, tell } from "./store.js";

const LABELS = {
  length_m: "Length of the pool", width_m: "Width of the pool", depth_m: "Depth of the water", density_kg_m3: "Density of the water",
  refractive_index: "Refractive index of the water", mass_kg: "Mass", yaw_inertia_kg_m2: "Yaw inertia",
  body_length_m: "Body length", head_length_m: "Head length (standard head)", head_span_m: "Head span",
  hinge_to_com_m: "Hinge to centre of mass", tail_length_m: "Tail length", keypoint_depth_m: "Depth of the keypoints",
  model: "Lens model", image_size_px: "Image size", matrix: "Camera matrix", distortion: "Distortion",
  pool_corners_px: "Corners of the pool", pool_corners_height_m: "Height of the corners", source: "Detector", body: "Body", marker_hues_deg: "Hues of the dots",
};

// A key in the words of its field: "Body length" for robot.body_length_m.
export const label = (key) => LABELS[key.split(".")[1]] ?? key;
const DETECTORS = ["silhouette", "markers"];
const REQUIRED = "required";
const LISTS = ["camera.image_size_px", "camera.matrix", "camera.distortion"];
const EXAMPLES = { "camera.image_size_px": "[1920, 1080]", "camera.distortion": "[-0.03, 0.01, 0, 0]",
  "camera.matrix": "[[1140, 0, 960], [0, 1140, 540], [0, 0, 1]]" };
export const words = ({ text }) => (/^found (nothing|None);/.test(text) ? REQUIRED : text);

// A minus sign as word processors write it.
export const plainMinus = (text) => text.replace(/^\u2212(?=[\d.])/, "-");

// A list typed without brackets: "1920 x 1080", "-0.03, 0.01, 0, 0", nine numbers of a matrix.
function tidy(key, text) {
  const plain = text.trim().replaceAll("\u2212", "-");
  if (!LISTS.includes(key) || !plain || /[[\]]/.test(plain)) return plainMinus(text);
  const parts = plain.split(/[\s,;x\u00d7]+/).filter(Boolean);
  if (!parts.every((one) => Number.isFinite(Number(one)))) return text;
  if (key !== "camera.matrix") return `[${parts.join(", ")}]`;
  if (parts.length !== 9) return text;
  return `[${[0, 3, 6].map((k) => `[${parts.slice(k, k + 3).join(", ")}]`).join(", ")}]`;
}

export function field(key) {
  const found = store.keys.find((one) => one.file === "study.yaml" && one.name === key);
  const name = key.split(".")[1];
  const choices = key === "detection.source" ? DETECTORS
    : /^[\w-]+( or [\w-]+)+$/.test(found.allowed) ? found.allowed.split(" or ") : null;
  const input = choices
    ? element("select", {}, element("option", { value: "", textContent: `(${found.default})` }),
      ...choices.map((value) => element("option", { value, textContent: value })))
    : element("input", { autocomplete: "off" });
  input.id = key;
  input.dataset.key = key;
  const usual = found.default && found.default !== "required" && !key.startsWith("pool.") ? ` Usually ${found.default}.` : "";
  if (!choices && /_(m|kg|m2|m3|index)$/.test(name)) input.inputMode = "decimal";
  input.setAttribute("aria-describedby", `${key}-hint ${key}-error`);
  input.value = store.values[key] ?? "";
  input.addEventListener(choices ? "change" : "input", () => setValue(key, input.value));
  if (!choices) {
    if (EXAMPLES[key]) input.placeholder = EXAMPLES[key];
    input.addEventListener("change", () => { input.value = tidy(key, input.value); setValue(key, input.value); });
  }
  input.addEventListener("focus", () => tell("focus", key));
  const unit = found.unit && found.unit !== "1" ? ` [${found.unit}]` : "";
  const needed = found.default === "required" || key.startsWith("pool.");
  return element("div", { className: "field" },
    element("label", { htmlFor: key, textContent: `${label(key)}${unit}${needed ? "" : " (optional)"}` }),
    input,
    element("p", { id: `${key}-hint`, className: "hint", textContent: `${found.meaning}${usual}`.replaceAll("`", "") }),
    element("p", { id: `${key}-error`, className: "error" }));
}

export function fill(place, keys) {
  document.getElementById(place).replaceChildren(...keys.map(field));
}

function refresh(key) {
  const input = document.getElementById(key);
  if (input && input !== document.activeElement && "value" in input) input.value = store.values[key] ?? "";
}

on("value", refresh);
on("reload", () => document.querySelectorAll("[data-key]").forEach((input) => refresh(input.dataset.key)));
on("findings", () => {
  document.querySelectorAll("[id$='-error']").forEach((place) => {
    if (place.closest("#trials-table")) return;
    const key = place.id.slice(0, -6);
    const all = store.findings.filter((one) => one.key === key).map(words);
    const texts = all.some((text) => text !== REQUIRED) ? all.filter((text) => text !== REQUIRED) : all;
    // A field that was never touched is not called wrong before the last step.
    const untouched = !store.values[key] && texts.every((text) => text === REQUIRED);
    place.textContent = untouched && !store.insist ? "" : texts.join(" ");
    document.getElementById(key)?.setAttribute("aria-invalid", String(Boolean(place.textContent)));
  });
});
