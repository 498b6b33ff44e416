// The draft of the study, what is wrong with it, and the questions to the server.

export const store = { values: {}, rows: [], revision: "", keys: [], files: {}, findings: [],
  newRows: [], recorded: [], dirty: false, previews: new Map(), previewErrors: new Map(), folder: "" };
const listeners = new Map();

export function on(event, work) {
  if (!listeners.has(event)) listeners.set(event, []);
  listeners.get(event).push(work);
}

export function tell(event, detail) {
  for (const work of listeners.get(event) ?? []) work(detail);
}

export async function ask(name, content) {
  const options = content === undefined ? {} : { method: "POST",
    headers: { "Content-Type": "application/json" }, body: JSON.stringify(content) };
  let response;
  try {
    response = await fetch(name, options);
  } catch {
    throw new Error("The server does not answer. Is `bluekoi setup` still running in the terminal?");
  }
  const answer = await response.json().catch(() => ({ error: response.statusText }));
  if (!response.ok) throw new Error(answer.error ?? response.statusText);
  return answer;
}

export const draft = () => ({ values: store.values, rows: store.rows, revision: store.revision });

export function take(found) {
  store.values = found.values;
  store.rows = found.rows;
  store.revision = found.revision;
}

let checking, checks = 0;
async function check(files = false) {
  const count = ++checks;
  try {
    const found = await ask("check", { ...draft(), files });
    if (count !== checks) return;
    store.findings = found.findings;
    tell("findings");
  } catch (error) {
    trouble(error.message);
  }
}

export function checkNow(files) {
  clearTimeout(checking);
  return check(files);
}

export function changed() {
  store.dirty = true;
  tell("changed");
  clearTimeout(checking);
  checking = setTimeout(check, 350);
}

export function setValue(key, text) {
  if ((store.values[key] ?? "") === text) return;
  if (text.trim()) store.values[key] = text;
  else delete store.values[key];
  changed();
  tell("value", key);
}

export function trouble(text) {
  const place = document.getElementById("trouble");
  place.textContent = text;
  place.hidden = !text;
}

// Trials whose preview found the robot in fewer than half of the frames, and why.
export const notFound = () => store.rows.flatMap(({ trial_id: trial }) => {
  const found = store.previews.get(trial), error = store.previewErrors.get(trial);
  if (error && error !== "stopped") return [`${trial}: not previewed`];
  return found && found.found < 0.5 * found.frames ? [`${trial}: robot found in ${found.found} of ${found.frames} frames`] : [];
});

export const numbers = (text) => {
  try { return JSON.parse(text); } catch { return null; }
};

export function element(name, properties = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(properties)) {
    if (key in made) made[key] = value;
    else made.setAttribute(key, value);
  }
  made.append(...children);
  return made;
}
