// Headings sort their table; a second click reverses the order. Empty cells stay last.
for (const table of document.querySelectorAll("table.sortable")) {
  const body = table.tBodies[0];
  table.querySelectorAll("thead th").forEach((heading, column) => {
    const title = heading.textContent.trim();
    heading.replaceChildren(button(title, () => {
      const up = heading.getAttribute("aria-sort") !== "ascending";
      table.querySelectorAll("thead th").forEach((other) => other.setAttribute("aria-sort", "none"));
      heading.setAttribute("aria-sort", up ? "ascending" : "descending");
      const key = (row) => row.cells[column].dataset.key ?? row.cells[column].textContent.trim();
      const order = (a, b) => {
        const [x, y] = [key(a), key(b)];
        if (x === "" || y === "") return (x === "") - (y === "");
        const [p, q] = [Number(x), Number(y)];
        const way = Number.isNaN(p) || Number.isNaN(q) ? x.localeCompare(y) : p - q;
        return up ? way : -way;
      };
      body.replaceChildren(...[...body.rows].sort(order));
      filterTrials();
    }));
  });
}
// Search field and lists choose the trials of table, thumbnails and explorer.
const filters = { text: document.getElementById("filter"), power: document.getElementById("filter-power"),
  quality: document.getElementById("filter-quality") };
const rowOf = new Map([...document.querySelectorAll("#trial-table tbody tr")].map((row) => [row.dataset.trial, row]));
function filterTrials() {
  const wanted = filters.text.value.toLowerCase().split(/\s+/).filter(Boolean);
  const { power: { value: power }, quality: { value: quality } } = filters;
  for (const card of cards) {
    const row = rowOf.get(card.dataset.trial);
    const text = row.textContent.toLowerCase();
    const kept = wanted.every((word) => text.includes(word)) && (!power || card.dataset.power === power)
      && (!quality || card.dataset.quality === quality);
    row.hidden = card.hidden = !kept;
  }
  shownIds = [...document.querySelectorAll("#trial-table tbody tr:not([hidden])")].map((row) => row.dataset.trial);
  listTrials();
}
for (const [key, field] of Object.entries(filters)) {
  field.addEventListener("input", filterTrials);
  if (key === "text") continue;
  const values = [...new Set(cards.map((card) => card.dataset[key]))].sort((a, b) => a.localeCompare(b, "en", { numeric: true }));
  field.append(...values.map((text) => Object.assign(document.createElement("option"), { value: text, textContent: text })));
}
filters.text.addEventListener("keydown", (event) => {
  if (event.key !== "Escape" || !filters.text.value) return;
  event.preventDefault();
  filters.text.value = "";
  filterTrials();
});
// Print all details.
window.addEventListener("beforeprint", () => {
  document.querySelectorAll("details").forEach((one) => { one.open = true; });
});
fromAddress();
