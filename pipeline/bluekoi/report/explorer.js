// Trial explorer: one trial's video, paths and time series on one time scrubber.
const explorer = document.getElementById("explorer");
const part = (name) => document.getElementById(`explorer-${name}`);
const cards = [...document.querySelectorAll(".card")];
const COLOURS = { measured: "#20262e", before: "#d55e00", after: "#56b4e9" };
const NAMES = { measured: "measured", before: explorer.dataset.before, after: explorer.dataset.after };
const DEGREES = 180 / Math.PI;
const QUANTITIES = [
  { name: "speed", unit: "m/s", of: (c) => c.speed_m_s, std: (c) => c.speed_m_s_std },
  { name: "yaw rate", unit: "rad/s", of: (c) => c.yaw_rate_rad_s, std: (c) => c.yaw_rate_rad_s_std },
  { name: "heading", unit: "°", of: (c) => c.heading_rad?.map((v) => v === null ? null : v * DEGREES) },
  { name: "head angle", unit: "°", of: (c) => c.head_angle_rad?.map((v) => v === null ? null : v * DEGREES) },
  { name: "path error", unit: "mm", of: (c) => c.error_mm },
];
const READOUT = [{ name: "x", unit: "m", of: (c) => c.x_m }, { name: "y", unit: "m", of: (c) => c.y_m }, ...QUANTITIES];
const now = { id: "", data: null, time: 0, playing: false, busy: false, drawn: null };
let shownIds = cards.map((card) => card.dataset.trial);

// Columns are stored as rounded differences.
function restored({ unit, steps }) {
  let sum = 0;
  return steps.map((step) => step === null ? null : (sum += step) * unit);
}
async function load(card) {
  const text = packedText(`series-${card.dataset.trial}`);
  if (!text) return null;
  const data = JSON.parse(await unpack(text));
  for (const columns of Object.values(data)) {
    for (const name of Object.keys(columns)) columns[name] = restored(columns[name]);
  }
  for (const kind of ["before", "after"].filter((k) => data[k])) {
    const [a, b] = [data[kind], data.measured];
    a.error_mm = a.x_m.map((x, i) => x === null ? null : 1000 * Math.hypot(x - b.x_m[i], a.y_m[i] - b.y_m[i]));
  }
  return data;
}
const times = () => now.data?.measured.time_s ?? [0];
const first = () => times()[0];
const last = () => times().at(-1);
function indexAt(time) {
  const at = times();
  let [low, high] = [0, at.length - 1];
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (at[middle] <= time + 1e-6) low = middle; else high = middle - 1;
  }
  return low;
}

// Selection.
async function select(id, focus = false) {
  const card = cards.find((one) => one.dataset.trial === id);
  if (!card) return;
  pause();
  now.id = id;
  part("select").value = id;
  for (const one of cards) one.classList.toggle("selected", one === card);
  part("info").textContent = `${card.querySelector("p").textContent.trim()}; quality: ${card.dataset.quality}`
    + (card.dataset.reason ? ` (${card.dataset.reason})` : "");
  showVideo(card);
  now.data = await load(card);
  part("empty").hidden = Boolean(now.data);
  part("charts").hidden = !now.data;
  const scrubber = part("time");
  [scrubber.min, scrubber.max] = [first(), last()];
  scrubber.disabled = !now.data;
  if (now.data) await draw();
  seek(first());
  if (focus) { explorer.scrollIntoView({ block: "start" }); explorer.focus({ preventScroll: true }); }
}
function step(by) {
  const place = shownIds.indexOf(now.id) + by;
  if (place >= 0 && place < shownIds.length) select(shownIds[place]);
}
function listTrials() {
  const option = (id) => Object.assign(document.createElement("option"), { value: id, textContent: id });
  part("select").replaceChildren(...shownIds.map(option));
  part("count").textContent = `${shownIds.length} of ${cards.length} trials`;
  if (shownIds.includes(now.id)) part("select").value = now.id;
  else if (now.id && shownIds.length) select(shownIds[0]);
}

// Video: embedded, or loaded from its file beside the page.
const video = part("video");
function showVideo(card) {
  const clip = document.getElementById(`clip-${card.dataset.trial}`);
  if (video.src.startsWith("blob:")) URL.revokeObjectURL(video.src);
  video.removeAttribute("src");
  const link = card.dataset.video;
  video.hidden = !link;
  part("no-video").hidden = Boolean(link);
  part("no-video").textContent = "This trial has no video.";
  video.dataset.start = card.dataset.start || "0";
  if (clip) video.src = URL.createObjectURL(new Blob([bytesOf(clip.textContent.trim())], { type: "video/mp4" }));
  else if (link) video.src = link;
  video.load();
}
video.addEventListener("error", () => {
  if (!video.getAttribute("src") || video.hidden) return;
  video.hidden = true;
  part("no-video").hidden = false;
  part("no-video").textContent = video.src.startsWith("blob:") ? "This browser cannot play the video (mp4, H.264)."
    : `The video file ${video.getAttribute("src")} is not beside this page, or this browser cannot play it.`;
});
video.addEventListener("loadedmetadata", () => { video.currentTime = now.time - Number(video.dataset.start); });
const hasVideo = () => !video.hidden && video.readyState > 0;

// Time.
function seek(time, fromVideo = false) {
  now.time = Math.min(Math.max(time, first()), last());
  part("time").value = now.time;
  part("clock").textContent = `${now.time.toFixed(2)} s of ${last().toFixed(2)} s`;
  part("time").setAttribute("aria-valuetext", `${now.time.toFixed(2)} seconds`);
  if (hasVideo() && !fromVideo) video.currentTime = Math.max(0, now.time - Number(video.dataset.start));
  if (now.data) { readout(); mark(); }
}
function play() {
  if (!now.data) return;
  if (now.time >= last() - 1e-3) seek(first());
  now.playing = true;
  part("play").textContent = "Pause";
  const rate = Number(part("rate").value);
  let [clock, from] = [performance.now(), now.time];
  if (hasVideo()) { video.playbackRate = rate; video.play().catch(() => {}); }
  const tick = (at) => {
    if (!now.playing) return;
    if (hasVideo() && video.seeking) { clock = at; requestAnimationFrame(tick); return; }
    const driven = hasVideo() && !video.paused;
    seek(driven ? video.currentTime + Number(video.dataset.start) : from + rate * (at - clock) / 1000, true);
    if (driven) [clock, from] = [at, now.time];
    if (now.time >= last() - 1e-3 || (hasVideo() && video.ended)) pause(); else requestAnimationFrame(tick);
  };
  requestAnimationFrame(tick);
}
function pause() {
  now.playing = false;
  video.pause();
  part("play").textContent = "Play";
}
const toggle = () => now.playing ? pause() : play();

// Values at the current time.
function readout() {
  const i = indexAt(now.time);
  const kinds = Object.keys(now.data);
  const cell = (text, tag = "td") => Object.assign(document.createElement(tag), { textContent: text });
  const row = (cells) => { const one = document.createElement("tr"); one.append(...cells); return one; };
  const text = (quantity, columns) => {
    const [value, std] = [quantity.of(columns)?.[i], quantity.std?.(columns)?.[i]];
    if (value === null || value === undefined) return "–";
    const usual = quantity.unit === "°" || quantity.unit === "mm" ? 1 : 3;
    const digits = std ? Math.min(4, Math.max(usual, Math.ceil(-Math.log10(1.96 * std)))) : usual;
    return value.toFixed(digits) + (std ? ` ± ${(1.96 * std).toFixed(digits)}` : "") + ` ${quantity.unit}`;
  };
  const body = READOUT.map((quantity) => row([cell(quantity.name, "th"), ...kinds.map((k) => cell(text(quantity, now.data[k])))]));
  const table = part("readout");
  table.tHead.replaceChildren(row([cell("quantity", "th"), ...kinds.map((k) => cell(NAMES[k], "th"))]));
  table.tBodies[0].replaceChildren(...body);
}

// Charts.
async function draw() {
  const Plotly = await plotly();
  const { data } = now;
  const kinds = Object.keys(data);
  const [length, width] = [Number(explorer.dataset.length), Number(explorer.dataset.width)];
  const line = (kind) => ({ color: COLOURS[kind], width: kind === "measured" ? 3 : 1.8, dash: kind === "before" ? "dash" : "solid" });
  const paths = kinds.map((kind) => ({ name: NAMES[kind], x: data[kind].x_m, y: data[kind].y_m, customdata: times(),
    mode: "lines", line: line(kind), hovertemplate: "x %{x:.3f} m<br>y %{y:.3f} m<br>t %{customdata:.2f} s" }));
  const dots = kinds.map((kind) => ({ x: [null], y: [null], mode: "markers", showlegend: false, hoverinfo: "skip",
    marker: { size: 11, color: COLOURS[kind], line: { color: "#fff", width: 2 } } }));
  await Plotly.react(part("path"), [...paths, ...dots], { font: FONT, height: Math.min(400, 0.62 * part("path").clientWidth + 112), uirevision: now.id, hovermode: "closest",
    margin: { l: 50, r: 10, t: 32, b: 40 }, legend: { orientation: "h", y: -0.16 },
    shapes: [{ type: "rect", x0: 0, y0: 0, x1: length, y1: width, line: { color: "#8fa3b0" }, fillcolor: "#f2f7fa", layer: "below" }],
    xaxis: { ...titled("x (m)"), range: [-0.05, length + 0.05], constrain: "domain" },
    yaxis: { ...titled("y (m)"), range: [-0.05, width + 0.15], scaleanchor: "x", constrain: "domain" } }, CONFIG);
  const shown = QUANTITIES.filter((quantity) => kinds.some((kind) => quantity.of(data[kind])));
  const axis = (k) => k ? `y${k + 1}` : "y";
  const traces = shown.flatMap((quantity, k) => kinds.filter((kind) => quantity.of(data[kind])).flatMap((kind) => {
    const [y, std] = [quantity.of(data[kind]), quantity.std?.(data[kind])];
    const common = { x: times(), yaxis: axis(k), mode: "lines", legendgroup: kind };
    const edge = (sign) => ({ ...common, y: y.map((v, i) => v === null ? null : v + sign * 1.96 * std[i]), line: { width: 0 },
      showlegend: false, hoverinfo: "skip", ...(sign > 0 ? { fill: "tonexty", fillcolor: "#20262e22" } : {}) });
    return [...(std ? [edge(-1), edge(1)] : []), { ...common, y, name: NAMES[kind], showlegend: k === 0, line: { ...line(kind), width: 1.6 },
      hovertemplate: `${quantity.name} %{y:.4g} ${quantity.unit}` }];
  }));
  const layout = { font: FONT, height: 110 * shown.length + 90, uirevision: now.id, hovermode: "x unified",
    margin: { l: 64, r: 10, t: 10, b: 40 }, legend: { orientation: "h", y: 1.02, yanchor: "bottom" },
    xaxis: { ...titled("time (s)"), unifiedhovertitle: { text: "time %{x:.2f} s" }, range: [first(), last()], anchor: axis(shown.length - 1) }, shapes: [] };
  shown.forEach((quantity, k) => {
    const top = 1 - k / shown.length;
    layout[k ? `yaxis${k + 1}` : "yaxis"] = { ...titled(`${quantity.name}<br>(${quantity.unit})`), domain: [top - 0.88 / shown.length, top] };
  });
  await Plotly.react(part("series"), traces, layout, CONFIG);
  now.drawn = { kinds, count: paths.length };
  for (const chart of [part("path"), part("series")]) {
    chart.removeAllListeners("plotly_click");
    chart.on("plotly_click", ({ points: [point] }) => seek(point.customdata ?? point.x));
  }
}
// Current position on both charts; skipped while the last update is still being drawn.
async function mark() {
  if (!now.drawn || now.busy) { now.again = true; return; }
  now.busy = true;
  const i = indexAt(now.time);
  const at = (name) => now.drawn.kinds.map((kind) => [now.data[kind][name][i]]);
  await Plotly.restyle(part("path"), { x: at("x_m"), y: at("y_m") }, now.drawn.kinds.map((_, k) => now.drawn.count + k));
  await Plotly.relayout(part("series"), { shapes: [{ type: "line", x0: now.time, x1: now.time, y0: 0, y1: 1, yref: "paper",
    line: { color: "#0072b2", width: 1.5 } }] });
  now.busy = false;
  if (now.again) { now.again = false; mark(); }
}
function zoom(factor) {
  if (!now.drawn) return;
  const [low, high] = part("series").layout.xaxis.range;
  const half = Math.min(0.5 * (high - low) * factor, 0.5 * (last() - first()));
  const range = factor === 0 ? [first(), last()] : [Math.max(first(), now.time - half), Math.min(last(), now.time + half)];
  Plotly.relayout(part("series"), { "xaxis.range": range });
}

function trialCsv() {
  const columns = Object.entries(now.data).flatMap(([kind, found]) => Object.entries(found).map(
    ([name, values]) => [kind === "measured" ? name : `${kind}_${name}`, values]));
  const rows = times().map((_, i) => columns.map(([, values]) => values[i] === null ? "" : Number(values[i].toPrecision(7))));
  save(`${now.id}.csv`, csvText([columns.map(([name]) => name), ...rows]));
}

// Controls and keyboard.
part("select").addEventListener("change", () => select(part("select").value));
part("previous").addEventListener("click", () => step(-1));
part("next").addEventListener("click", () => step(1));
part("play").addEventListener("click", toggle);
part("time").addEventListener("input", () => { pause(); seek(Number(part("time").value)); });
part("csv").addEventListener("click", () => now.data && trialCsv());
for (const [name, factor] of [["in", 0.5], ["out", 2], ["all", 0]]) part(`zoom-${name}`).addEventListener("click", () => zoom(factor));
const frame = () => (last() - first()) / Math.max(1, times().length - 1);
const KEYS = { " ": toggle, ArrowRight: (e) => jump(e.shiftKey ? 1 : frame()), ArrowLeft: (e) => jump(e.shiftKey ? -1 : -frame()),
  Home: () => jump(-1e9), End: () => jump(1e9), n: () => step(1), p: () => step(-1),
  "+": () => zoom(0.5), "-": () => zoom(2), 0: () => zoom(0), Escape: leave };
// Back to the trial in the table.
function leave() {
  pause();
  const link = document.querySelector(`#trial-table a[href="#trial-${now.id}"]`);
  link?.scrollIntoView({ block: "center" });
  link?.focus({ preventScroll: true });
}
function jump(by) { pause(); seek(now.time + by); }
explorer.addEventListener("keydown", (event) => {
  const { target } = event;
  if (event.ctrlKey || event.metaKey || event.altKey || target.matches("select, input:not([type=range])")) return;
  if (event.key === " " && target.matches("button, summary, video")) return;
  if (!(event.key in KEYS)) return;
  event.preventDefault();
  KEYS[event.key](event);
});
const fromAddress = () => {
  const id = decodeURIComponent(location.hash).replace(/^#trial-/, "");
  if (location.hash.startsWith("#trial-") && cards.some((card) => card.dataset.trial === id)) select(id, true);
};
addEventListener("hashchange", fromAddress);
for (const link of document.querySelectorAll('a[href^="#trial-"]')) {
  link.addEventListener("click", () => { if (link.hash === location.hash) fromAddress(); });
}
explorer.hidden = false;
listTrials();
new IntersectionObserver((entries, observer) => {
  if (!entries.some((entry) => entry.isIntersecting)) return;
  observer.disconnect();
  if (!now.id && shownIds.length) select(shownIds[0]);
}, { rootMargin: "400px" }).observe(explorer);
