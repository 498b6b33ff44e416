// The last step: what is still wrong, the run and its lines, the report.

import { words } from "./fields.js";
import { ask, checkNow, element, notFound, on, store, tell } from "./store.js";

const id = (name) => document.getElementById(name);
let timer;

export function stepOf(finding) {
  if (finding.row !== null || finding.column) return "trials";
  const section = finding.key.split(".")[0];
  if (finding.key.startsWith("camera.pool_corners")) return "pool";
  return { pool: "pool", camera: "camera", water: "camera", robot: "robot", detection: "robot" }[section] ?? "run";
}

function placeOf(finding) {
  if (finding.row === null) return finding.key;
  const name = store.rows[finding.row]?.trial_id || `row ${finding.row + 1}`;
  return `${name}${finding.column ? `, ${finding.column}` : ""}`;
}

function findings() {
  const items = store.findings.map((one) => {
    const link = element("a", { href: `#${stepOf(one)}`, textContent: placeOf(one) || "study" });
    link.onclick = () => setTimeout(() => tell("go", one), 50);
    return element("li", {}, link, `: ${words(one)}`);
  });
  const good = items.length ? [] : [element("li", { className: "good", textContent: "Nothing is wrong in study.yaml and trials.csv." })];
  const doubts = notFound().map((text) => element("li", {}, element("a", { href: "#preview", textContent: "Preview" }), `: ${text}. Look at this trial before the run.`));
  if (store.fit && !store.fit.confirmed)
    doubts.push(element("li", {}, element("a", { href: "#pool", textContent: "Pool" }), ": the edges seen do not confirm the corners."));
  id("run-findings").replaceChildren(...items, ...good, ...doubts);
  id("run-start").disabled = items.length > 0 || running;
}

let running = false;
function shown(state) {
  running = state.running;
  const lines = state.lines, box = id("run-lines");
  const end = box.scrollTop + box.clientHeight >= box.scrollHeight - 8;
  box.textContent = lines.join("\n");
  if (end) box.scrollTop = box.scrollHeight;
  const step = lines.map((one) => one.match(/^\[(\d+)\/(\d+)\]/)).filter(Boolean).pop();
  id("run-progress").hidden = !running;
  if (step) id("run-progress").value = Number(step[1]) / Number(step[2]);
  const ended = { 0: "The run is complete.", 3: "The run is complete, but some trials went wrong: see above and the report.",
    143: "The run was stopped; what is done is kept. Save and run continues it." }[state.exit_code]
    ?? `The run ended with an error (exit code ${state.exit_code}): see the lines.`;
  id("run-said").textContent = running ? `Running${step ? `: ${step[1]} of ${step[2]}` : " …"}` : state.begun ? ended : "";
  id("run-report").hidden = !state.report || running;
  id("run-start").disabled = running || store.findings.length > 0;
  id("run-stop").disabled = !running;
  clearTimeout(timer);
  if (running) timer = setTimeout(follow, 700);
}

async function follow() {
  try { shown(await ask("run")); } catch (error) { id("run-said").textContent = error.message; }
}

export function start(save) {
  on("findings", findings);
  id("run-check").onclick = async () => {
    id("run-said").textContent = "Opening all files …";
    await checkNow(true);
    id("run-said").textContent = store.findings.length ? "" : "All files can be read.";
  };
  id("run-start").onclick = async () => {
    if (!(await save())) return;
    id("run-said").textContent = "Opening all files …";
    await checkNow(true);
    if (store.findings.length) { id("run-said").textContent = "Mend this first."; return; }
    try { shown(await ask("start", {})); } catch (error) { id("run-said").textContent = error.message; }
  };
  id("run-stop").onclick = async () => {
    id("run-said").textContent = "Stopping after the jobs at work …";
    await ask("stop", {});
  };
}

export function show() {
  store.insist = true;
  checkNow();
  follow();
}
