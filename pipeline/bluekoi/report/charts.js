// Embedded data, csv downloads, and interactive versions of the figures.
const packedText = (id) => document.getElementById(id)?.textContent.trim() ?? "";
const bytesOf = (base64) => Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
const unpack = (base64) => new Response(
  new Blob([bytesOf(base64)]).stream().pipeThrough(new DecompressionStream("gzip"))).text();

// The plotting library is unpacked and run when the first chart is drawn.
let library;
const plotly = () => library ??= unpack(packedText("plotly")).then((source) => {
  const script = document.createElement("script");
  script.textContent = source;
  document.head.append(script);
  return window.Plotly;
});
const CONFIG = { responsive: true, displaylogo: false, scrollZoom: false,
  modeBarButtonsToRemove: ["select2d", "lasso2d", "zoomIn2d", "zoomOut2d", "autoScale2d"], toImageButtonOptions: { format: "svg" } };
const FONT = { family: "system-ui, DejaVu Sans, sans-serif", size: 12, color: "#1c2630" };
const titled = (text) => ({ title: { text, standoff: 6 }, automargin: true, zeroline: false });

function save(name, text) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text], { type: "text/csv" }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}
const quoted = (cell) => /[",\n]/.test(cell) ? `"${cell.replaceAll('"', '""')}"` : cell;
const csvText = (rows) => rows.map((row) => row.map((c) => quoted(String(c))).join(",")).join("\n") + "\n";
function csvRows(text) {
  const rows = [];
  let row = [], cell = "", inside = false;
  for (let i = 0; i < text.length; i += 1) {
    const letter = text[i];
    if (inside) {
      if (letter !== '"') cell += letter;
      else if (text[i + 1] === '"') { cell += '"'; i += 1; } else inside = false;
    } else if (letter === '"') inside = true;
    else if (letter === ",") { row.push(cell); cell = ""; }
    else if (letter === "\n") { rows.push([...row, cell]); row = []; cell = ""; }
    else cell += letter;
  }
  return rows;
}
function button(text, action) {
  const one = document.createElement("button");
  one.type = "button";
  one.textContent = text;
  one.addEventListener("click", action);
  return one;
}
const fileName = (text) => text.toLowerCase().replaceAll(/[^a-z0-9]+/g, "_").slice(0, 60).replace(/^_|_$/g, "") + ".csv";

// A csv of every table.
for (const table of document.querySelectorAll("table")) {
  const caption = table.caption?.textContent.trim() || "table";
  const cells = (row) => [...row.cells].map((c) => c.textContent.trim().replace(/\s+/g, " "));
  const one = button("csv", () => save(fileName(caption), csvText([...table.rows].map(cells))));
  one.className = "screen download";
  one.setAttribute("aria-label", `Download csv: ${caption}`);
  table.caption?.append(" ", one);
}
// A csv and an interactive version of every figure with data.
for (const figure of document.querySelectorAll("figure[data-figure]")) {
  const id = `data-${figure.dataset.figure}`;
  figure.querySelector(".download")?.addEventListener("click", async () => {
    save(`${figure.dataset.figure}.csv`, await unpack(packedText(id)));
  });
  const details = figure.querySelector("details");
  details?.addEventListener("toggle", () => {
    if (!details.open || matchMedia("print").matches || details.dataset.drawn) return;
    details.dataset.drawn = "yes";
    drawPanels(details.querySelector(".panels"), id);
  });
}

async function drawPanels(target, id) {
  const [Plotly, text] = await Promise.all([plotly(), unpack(packedText(id))]);
  const [names, ...rows] = csvRows(text);
  const panels = new Map();
  for (const row of rows) {
    const point = Object.fromEntries(names.map((name, i) => [name, row[i]]));
    if (!panels.has(point.panel)) panels.set(point.panel, { head: point, artists: new Map() });
    const artists = panels.get(point.panel).artists;
    if (!artists.has(point.artist)) artists.set(point.artist, []);
    artists.get(point.artist).push(point);
  }
  for (const { head, artists } of panels.values()) {
    const div = document.createElement("div");
    div.className = "chart";
    target.append(div);
    const shown = new Set();
    const traces = [...artists.values()].flatMap((points) => traceOf(points, shown));
    await Plotly.newPlot(div, ...withSharedAxes(traces, layoutOf(head, shown.size)), CONFIG);
    div.on("plotly_click", ({ points: [point] }) => {
      const trial = point.data.meta;
      if (trial) location.hash = `trial-${trial}`;
    });
  }
  target.dataset.ready = "yes";
}
// Lines beside bars become shapes (a bar's axis has categories); coloured points share one scale.
function withSharedAxes(traces, layout) {
  const bars = traces.find((trace) => trace.type === "bar");
  if (bars) {
    const flat = traces.filter((trace) => trace.mode === "lines" && bars.orientation === "v");
    layout.shapes = flat.map((trace) => ({ type: "line", xref: "paper", x0: 0, x1: 1, y0: trace.y[0], y1: trace.y[0],
      line: trace.line, label: { text: trace.name, textposition: "end", font: { size: 11 } } }));
    layout[bars.orientation === "v" ? "xaxis" : "yaxis"].type = "category";
    if (bars.orientation === "h") layout.yaxis.autorange = "reversed";
    return [traces.filter((trace) => trace.type === "bar"), { ...layout, showlegend: false }];
  }
  const sizes = traces.flatMap((trace) => trace.marker?.coloraxis ? trace.marker.color.map(Math.abs) : []).sort((a, b) => a - b);
  const limit = sizes[Math.floor(0.98 * (sizes.length - 1))] || 1;
  if (sizes.length) layout.coloraxis = { colorscale: "RdBu", cmin: -limit, cmax: limit, colorbar: { thickness: 10 } };
  return [traces, layout];
}
// The legend below gets a row for each entry, so that it never takes the height of the plot.
function layoutOf(head, entries) {
  const equal = head.equal_scales === "True" ? { scaleanchor: "x", scaleratio: 1, constrain: "domain" } : {};
  return { title: { text: head.title, font: { size: 13 }, x: 0, xanchor: "left", y: 1, yref: "paper", yanchor: "bottom", pad: { b: 8 } }, font: FONT, height: 360 + 22 * entries, hovermode: "closest",
    margin: { l: 60, r: 20, t: 60, b: 50 + 22 * entries }, showlegend: entries > 0,
    legend: { orientation: "v", x: 0, yref: "container", y: 0, yanchor: "bottom" },
    xaxis: { ...titled(head.x_label), constrain: "domain" }, yaxis: { ...titled(head.y_label), ...equal } };
}
const value = (text) => text === "" ? null : Number.isNaN(Number(text)) ? text : Number(text);
function traceOf(points, shown) {
  const [{ kind, series, trial_id: trial, colour, x_label: xLabel, y_label: yLabel }] = points;
  const column = (name) => points.map((point) => value(point[name]));
  const labelled = series && !shown.has(series);
  if (series) shown.add(series);
  const named = [trial, series].filter(Boolean).join(", ");
  const common = { name: series || trial, legendgroup: series, showlegend: Boolean(labelled), meta: trial,
    hovertemplate: `${named ? named + "<br>" : ""}${xLabel || "x"}: %{x}<br>${yLabel || "y"}: %{y}<extra></extra>` };
  const [x, y, low, high] = ["x", "y", "low", "high"].map(column);
  if (kind === "bar") {
    return [{ ...common, type: "bar", x, y, orientation: typeof y[0] === "string" ? "h" : "v", marker: { color: colour } }];
  }
  if (kind === "band") {
    const edge = { ...common, x, mode: "lines", line: { width: 0 }, showlegend: false, hoverinfo: "skip", hovertemplate: undefined };
    return [{ ...edge, y: low }, { ...edge, y: high, fill: "tonexty", fillcolor: `${colour}33` }];
  }
  if (kind === "line" || kind === "dashed line") {
    return [{ ...common, x, y, mode: "lines", line: { color: colour, width: 1.6, dash: kind === "line" ? "solid" : "dash" } }];
  }
  const values = column("value");
  const marker = values.some((v) => v !== null)
    ? { color: values, coloraxis: "coloraxis", size: 5 }
    : { color: colour, size: 6 };
  const extra = values.some((v) => v !== null) ? { customdata: values, hovertemplate: `${named}<br>%{x}, %{y}<br>value: %{customdata}<extra></extra>` } : {};
  const errors = high.some((v) => v !== null) ? { error_y: { type: "data", symmetric: false, thickness: 1, width: 3,
    array: high.map((v, i) => v - y[i]), arrayminus: low.map((v, i) => y[i] - v) } } : {};
  return [{ ...common, ...extra, x, y, mode: "markers", marker, ...errors }];
}
