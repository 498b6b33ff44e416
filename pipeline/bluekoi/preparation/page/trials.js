// trials.csv as a table: pre-filled, pasted into, filled down, every error under its cell.

import { plainMinus, words } from "./fields.js";
import { ask, changed, element, on, store } from "./store.js";

const USUAL = ["trial_id", "source", "power_pct", "head_angle_deg", "head_length_m", "motor_log"];
const id = (name) => document.getElementById(name);
let history = [], last = null;

function columns() {
  const all = store.keys.filter((key) => key.file === "trials.csv").map((key) => key.name);
  const used = new Set(store.rows.flatMap((row) => Object.keys(row).filter((name) => row[name])));
  const unknown = [...used].filter((name) => !all.includes(name));
  const needed = store.findings.filter((one) => one.column).map((one) => one.column);
  return [...all.filter((name) => id("trials-all").checked || USUAL.includes(name) || used.has(name) || needed.includes(name)), ...unknown];
}

function remember() {
  history.push(JSON.stringify(store.rows));
  if (history.length > 50) history.shift();
}

function about(k) {
  const found = store.recorded[k] ?? {}, texts = [];
  if (found.duration_s) texts.push(`${found.duration_s} s, ${found.fps} /s`);
  if (found.flap_hz) texts.push(`log: ${found.flap_hz} Hz`);
  const cell = element("td", { className: "about" }, texts.join("; "));
  for (const error of [found.error, found.log_error]) if (error) cell.append(element("p", { className: "error", textContent: error.split(": ").slice(1).join(": ") }));
  return cell;
}

function cell(k, name, texts) {
  const input = element("input", { value: store.rows[k][name] ?? "", autocomplete: "off", "aria-label": `${name} of row ${k + 1}` });
  input.dataset.row = k;
  input.dataset.column = name;
  const wide = ["source", "motor_log"].includes(name) ? "text" : name === "trial_id" ? "first" : "";
  const made = element("td", { className: wide }, input, element("p", { className: "error", id: `cell-${k}-${name}` }));
  input.setAttribute("aria-describedby", `cell-${k}-${name}`);
  mark(made, texts);
  return made;
}

function mark(place, texts) {
  const input = place.querySelector("input");
  const text = texts.join(" ");
  input.setAttribute("aria-invalid", String(Boolean(text)));
  place.querySelector(".error").textContent = text;
}

const errorsOf = (k, name) => store.findings.filter((one) => one.row === k && (one.column === name || (name === "trial_id" && !one.column))).map(words);

let drawn = "";
function render(force = false) {
  const names = columns();
  const layout = `${names} ${store.rows.length}`;
  if (!force && layout === drawn) {
    for (const input of id("trials-table").querySelectorAll("input")) mark(input.closest("td"), errorsOf(Number(input.dataset.row), input.dataset.column));
    return;
  }
  drawn = layout;
  const focus = last && { ...last };
  const head = element("thead", {}, element("tr", {}, ...names.map((name) => {
    const key = store.keys.find((one) => one.file === "trials.csv" && one.name === name);
    return element("th", { scope: "col", title: key?.meaning ?? "", textContent: name });
  }), element("th", { scope: "col", textContent: "recording" }), element("th", { scope: "col", textContent: "" })));
  const rows = store.rows.map((row, k) => {
    const remove = element("button", { textContent: "✕", "aria-label": `Delete row ${k + 1}`, title: "Delete this row" });
    remove.onclick = () => { remember(); store.rows.splice(k, 1); store.recorded.splice(k, 1); render(true); changed(); };
    return element("tr", {}, ...names.map((name) => cell(k, name, errorsOf(k, name))), about(k), element("td", {}, remove));
  });
  id("trials-table").replaceChildren(head, element("tbody", {}, ...rows));
  const meanings = store.keys.filter((key) => key.file === "trials.csv" && names.includes(key.name));
  id("trials-keys").replaceChildren(...meanings.flatMap((key) => [element("dt", { textContent: key.name }),
    element("dd", { textContent: key.meaning.replaceAll("`", "") + (key.unit ? ` [${key.unit}]` : "") })]));
  id("trials-new").hidden = !store.newRows.length;
  id("trials-new").textContent = `Add the ${store.newRows.length} files without a row`;
  if (focus && document.activeElement === document.body) select(focus.row, focus.column);
}

function select(row, column) {
  const input = id("trials-table").querySelector(`input[data-row="${row}"][data-column="${column}"]`);
  input?.focus();
  input?.select();
}

function set(k, name, text) {
  while (store.rows.length <= k) store.rows.push({});
  if (text) store.rows[k][name] = text;
  else delete store.rows[k][name];
}

function paste(event) {
  const input = event.target.closest("input[data-row]");
  const text = event.clipboardData.getData("text/plain").replace(/\r?\n$/, "");
  if (!input || !/[\t\n]/.test(text)) return;
  event.preventDefault();
  remember();
  const names = columns(), first = names.indexOf(input.dataset.column), top = Number(input.dataset.row);
  const lines = text.split(/\r?\n/).map((one) => one.split("\t"));
  lines.forEach((cells, i) => cells.forEach((value, j) => { if (names[first + j]) set(top + i, names[first + j], plainMinus(value.trim())); }));
  id("trials-said").textContent = `Pasted ${lines.length} rows.`;
  render(true);
  changed();
}

function fillDown() {
  if (!last) { id("trials-said").textContent = "Select a cell first."; return; }
  remember();
  const text = store.rows[last.row][last.column] ?? "";
  const next = store.rows[last.row + 1]?.[last.column] ?? "";
  let count = 0;
  for (let k = last.row + 1; k < store.rows.length; k += 1) {
    const old = store.rows[k][last.column] ?? "";
    if (!old || old === next) { set(k, last.column, text); count += 1; }
  }
  id("trials-said").textContent = `Filled ${count} cells below with ${text}${next ? `, in place of ${next}` : ""}.`;
  render(true);
  select(last.row, last.column);
  changed();
}

export function start() {
  const table = id("trials-table");
  table.addEventListener("input", ({ target }) => {
    set(Number(target.dataset.row), target.dataset.column, plainMinus(target.value.trim()));
    changed();
  });
  table.addEventListener("change", ({ target }) => {
    if (["source", "motor_log", "fps"].includes(target.dataset.column)) measure();
  });
  table.addEventListener("focusin", ({ target }) => {
    if (target.dataset.row) last = { row: Number(target.dataset.row), column: target.dataset.column };
  });
  table.addEventListener("focusin", ({ target }) => { if (target.dataset.row) history.length || remember(); });
  table.addEventListener("paste", paste);
  table.addEventListener("keydown", (event) => {
    const { row, column } = event.target.dataset;
    const step = { Enter: 1, ArrowDown: 1, ArrowUp: -1 }[event.key];
    if (row && step) { event.preventDefault(); select(Number(row) + (event.shiftKey ? -step : step), column); }
    if (row && event.ctrlKey && event.key.toLowerCase() === "d") { event.preventDefault(); fillDown(); }
  });
  id("trials-fill").onmousedown = (event) => event.preventDefault();
  id("trials-fill").onclick = fillDown;
  id("trials-add").onclick = () => { remember(); store.rows.push({}); render(true); changed(); };
  id("trials-new").onclick = () => { remember(); store.rows.push(...store.newRows.splice(0)); render(true); changed(); measure(); };
  id("trials-undo").onclick = () => {
    if (!history.length) return;
    store.rows = JSON.parse(history.pop());
    id("trials-said").textContent = "";
    render(true);
    changed();
  };
  id("trials-all").onchange = () => render(true);
  on("findings", () => render());
  on("reload", () => { render(true); });
}

let measured = "";
async function measure() {
  const rows = store.rows.map(({ source = "", motor_log = "", fps = "" }) => ({ source, motor_log, fps }));
  const now = JSON.stringify(rows);
  if (now === measured) return;
  measured = now;
  try {
    store.recorded = (await ask("recording_properties", { rows })).rows;
    document.querySelectorAll("#trials-table tbody tr").forEach((row, k) => row.querySelector(".about").replaceWith(about(k)));
  } catch (error) {
    id("trials-said").textContent = error.message;
  }
}

// The head length of the robot is that of every trial that says nothing else.
function headLengths() {
  const length = store.values["robot.head_length_m"];
  const empty = store.rows.filter((row) => row.source && !row.head_length_m);
  if (!length || !empty.length || store.headsFilled) return;
  store.headsFilled = true;
  for (const row of empty) row.head_length_m = length;
  id("trials-said").textContent = `head_length_m was filled with that of the robot (${length}); change it where a trial had another head.`;
  changed();
}

export function show() {
  headLengths();
  render(true);
  measure();
}
