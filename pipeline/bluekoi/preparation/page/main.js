// The page: steps, saving, and what is wrong where.

import * as camera from "./camera.js";
import * as pool from "./pool.js";
import * as preview from "./preview.js";
import * as robot from "./robot.js";
import * as run from "./run.js";
import { ask, checkNow, draft, element, notFound, on, store, take, tell, trouble } from "./store.js";
import * as trials from "./trials.js";

const STEPS = { pool, camera, robot, trials, preview, run };
const NAMES = Object.keys(STEPS);
const id = (name) => document.getElementById(name);
const title = (name) => id(`${name}-title`).textContent;

function steps() {
  id("steps").replaceChildren(...NAMES.map((name, k) => {
    const wrong = store.findings.filter((one) => run.stepOf(one) === name).length;
    const link = element("a", { href: `#${name}` }, `${k + 1} ${title(name)}`);
    if (wrong) link.append(element("span", { className: "count", textContent: wrong, title: `${wrong} entries missing or wrong` }));
    else if (name === "preview" && notFound().length) link.append(element("span", { className: "count", textContent: notFound().length, title: notFound().join("; ") }));
    else if (name === "pool" && store.fit && !store.fit.confirmed) link.append(element("span", { className: "count", textContent: "?", title: "the edges seen do not confirm the corners" }));
    else if (name === "camera" && !store.values["camera.matrix"]) link.append(element("span", { className: "fine", textContent: "–", title: "no calibration" }));
    else if (!["preview", "run"].includes(name)) link.append(element("span", { className: "fine", textContent: "✓", title: "complete" }));
    if (name === current()) link.setAttribute("aria-current", "step");
    return element("li", {}, link);
  }));
}

const current = () => (NAMES.includes(location.hash.slice(1)) ? location.hash.slice(1) : NAMES[0]);

function show() {
  const name = current();
  for (const one of NAMES) id(one).hidden = one !== name;
  id("back").disabled = name === NAMES[0];
  id("next").hidden = name === NAMES.at(-1);
  steps();
  trouble("");
  STEPS[name].show();
  scrollTo(0, 0);
}

async function save() {
  id("save").disabled = true;
  try {
    const found = await ask("save", draft());
    take(found.draft);
    store.dirty = false;
    store.findings = found.findings;
    const open = found.findings.length ? ` ${found.findings.length} entries are still missing or wrong.` : "";
    id("saved").textContent = (found.done.length ? `${found.done.join(", ")}.` : "Nothing had changed.") + open;
    trouble("");
    tell("findings");
    return true;
  } catch (error) {
    trouble(error.message);
    return false;
  } finally {
    id("save").disabled = false;
  }
}

async function begin() {
  const state = await ask("state");
  take(state.draft);
  Object.assign(store, { keys: state.keys, files: state.files, folder: state.folder, findings: state.findings,
    newRows: state.new_rows });
  id("folder").textContent = state.folder;
  id("notes").textContent = state.notes.join("\n");
  id("notes").hidden = !state.notes.length;
  document.title = `${state.folder.split("/").pop()}: BlueKoi study set-up`;
  for (const name of NAMES) STEPS[name].start(save);
  on("findings", steps);
  on("changed", () => { id("saved").textContent = "Not saved yet."; });
  on("go", (one) => {
    const cell = one.row === null ? id(one.key) : document.querySelector(`input[data-row="${one.row}"][data-column="${one.column || "trial_id"}"]`);
    cell?.focus();
  });
  tell("reload");
  tell("findings");
  addEventListener("hashchange", () => { show(); id(`${current()}-title`).focus({ preventScroll: true }); });
  id("save").onclick = save;
  id("back").onclick = () => { location.hash = NAMES[NAMES.indexOf(current()) - 1]; };
  id("next").onclick = () => { location.hash = NAMES[NAMES.indexOf(current()) + 1]; };
  addEventListener("keydown", (event) => {
    if ((event.ctrlKey || event.metaKey) && event.key.toLowerCase() === "s") { event.preventDefault(); save(); }
  });
  addEventListener("beforeunload", (event) => { if (store.dirty) event.preventDefault(); });
  show();
  document.body.dataset.ready = "yes";
  checkNow();
}

begin().catch((error) => trouble(error.message));
