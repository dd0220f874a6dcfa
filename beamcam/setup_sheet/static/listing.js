// The program's text: only the lines that can be seen are in the page, so that any length scrolls.
class Listing {
  constructor(box, lines, onPick) {
    this.box = box;
    this.lines = lines;
    this.now = 0;
    this.high = 20;
    this.space = document.createElement("div");
    this.space.className = "space";
    this.space.style.height = `${lines.length * this.high}px`;
    box.replaceChildren(this.space);
    box.addEventListener("scroll", () => this.draw());
    this.space.addEventListener("click", (event) => {
      const row = event.target.closest("[data-line]");
      if (row) onPick(Number(row.dataset.line));
    });
    this.draw();
    box.addEventListener("keydown", (event) => {
      const way = { ArrowDown: 1, ArrowUp: -1 }[event.key];
      if (!way) return;
      event.preventDefault();
      onPick(this.now + way, way);
    });
  }

  // Controls and what turns the direction of writing, as \u202e; the data keep them for the hash.
  static spelled(text) {
    return text.replace(/[\u007f-\u009f\u061c\u200b-\u200f\u2028-\u202e\u2066-\u2069\ufeff]/g,
      (sign) => `\\u${sign.charCodeAt(0).toString(16).padStart(4, "0")}`);
  }

  draw() {
    const first = Math.max(0, Math.floor(this.box.scrollTop / this.high) - 5);
    const count = Math.ceil((this.box.clientHeight || 300) / this.high) + 10;
    this.rows = new Map();
    for (let k = first; k < Math.min(first + count, this.lines.length); k++) {
      const row = document.createElement("div");
      row.className = k + 1 === this.now ? "row now" : "row";
      row.dataset.line = k + 1;
      row.style.top = `${k * this.high}px`;
      row.id = `line-${k + 1}`;
      row.setAttribute("role", "option");
      row.setAttribute("aria-selected", k + 1 === this.now);
      const number = document.createElement("span");
      number.textContent = k + 1;
      row.append(number, Listing.spelled(this.lines[k]));
      this.rows.set(k + 1, row);
    }
    this.space.replaceChildren(...this.rows.values());
  }

  show(line) {
    if (line === this.now) return;
    this.now = line;
    const top = (line - 1) * this.high;
    const { scrollTop, clientHeight } = this.box;
    if (line && (top < scrollTop || top > scrollTop + clientHeight - 2 * this.high)) {
      this.box.scrollTop = Math.max(0, top - clientHeight / 3);
    }
    this.box.setAttribute("aria-activedescendant", `line-${line}`);
    const row = this.rows?.get(line);
    if (!row) return this.draw();
    for (const other of this.rows.values()) if (other !== row) Listing.mark(other, false);
    Listing.mark(row, true);
  }

  static mark(row, is) {
    if (row.classList.contains("now") === is) return;
    row.classList.toggle("now", is);
    row.setAttribute("aria-selected", is);
  }
}
