"use strict";
// A click or Enter on a heading sorts its table by that column; a second one turns the order.
for (const table of document.querySelectorAll("table.sortable")) {
  const body = table.tBodies[0];
  table.querySelectorAll("thead th").forEach((heading, column) => {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = heading.textContent;
    heading.replaceChildren(button);
    button.addEventListener("click", () => {
      const up = heading.getAttribute("aria-sort") !== "ascending";
      table.querySelectorAll("th").forEach((other) => other.removeAttribute("aria-sort"));
      heading.setAttribute("aria-sort", up ? "ascending" : "descending");
      const key = (row) => row.cells[column].textContent.trim();
      const order = (a, b) => {
        const [x, y] = [parseFloat(key(a)), parseFloat(key(b))];
        const both = !Number.isNaN(x) && !Number.isNaN(y);
        return both ? x - y : key(a).localeCompare(key(b));
      };
      const rows = [...body.rows].sort(order);
      body.replaceChildren(...(up ? rows : rows.reverse()));
    });
  });
}
