"use strict";
// Filter and order of the files of a run; without a script the page shows them all.
const body = document.querySelector("#files tbody");
const rows = [...body.rows];
const said = document.getElementById("shown");
const words = document.getElementById("filter");
const status = document.getElementById("status");

function filter() {
  const wanted = words.value.toLowerCase().split(/\s+/).filter(Boolean);
  let count = 0;
  for (const row of rows) {
    const text = row.textContent.toLowerCase();
    const fits = (!status.value || row.dataset.status === status.value) &&
      wanted.every((word) => text.includes(word));
    row.hidden = !fits;
    count += fits;
  }
  said.textContent = `${count} of ${rows.length} shown`;
}

function order(head, column) {
  const down = head.getAttribute("aria-sort") === "ascending";
  for (const other of document.querySelectorAll("#files th")) other.removeAttribute("aria-sort");
  head.setAttribute("aria-sort", down ? "descending" : "ascending");
  const value = (row) => row.cells[column].dataset.value ?? row.cells[column].textContent;
  const compare = new Intl.Collator(undefined, { numeric: true }).compare;
  rows.sort((a, b) => (down ? -1 : 1) * compare(value(a), value(b)));
  body.append(...rows);
}

words.addEventListener("input", filter);
status.addEventListener("change", filter);
document.querySelectorAll("#files th").forEach((head, column) => {
  const button = head.querySelector("button");
  if (button) button.addEventListener("click", () => order(head, column));
});
filter();
