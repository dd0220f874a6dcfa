// Numbers as the reader's language writes them, lengths in the unit that was chosen. The values
// themselves stand in the page unchanged: <data value> and data-mm, always in millimetres.
const Numbers = {
  unit: "mm",
  locale: undefined,
  forms: new Map(),

  form(decimals, least = 0) {
    const key = `${decimals} ${least}`;
    if (!this.forms.has(key)) {
      this.forms.set(key, new Intl.NumberFormat(this.locale, {
        maximumFractionDigits: decimals, minimumFractionDigits: least, useGrouping: false,
      }));
    }
    return this.forms.get(key);
  },

  // A length; `fine` gives it all its decimals, so that a running figure does not jump.
  length(mm, fine = false) {
    const inch = this.unit === "inch";
    const decimals = (inch ? 3 : 1) + (fine ? 2 - inch : 0);
    return this.form(decimals, fine ? decimals : 0).format((inch ? mm / 25.4 : mm) + 0);
  },

  plain(value, decimals = 3, least = 0) {
    return this.form(decimals, least).format(value + 0);
  },

  clock(seconds) {
    const whole = Math.floor(seconds / 60);
    const rest = this.form(1, 1).format(seconds - 60 * whole);
    return `${whole}:${seconds - 60 * whole < 9.95 ? "0" : ""}${rest}`;
  },

  // Every length and number of the page.
  show(root) {
    for (const e of root.querySelectorAll("text[data-mm], tspan[data-mm]")) {
      const tip = e.querySelector("title");
      e.textContent = this.length(Number(e.dataset.mm));
      if (tip) e.prepend(tip);
    }
    for (const e of root.querySelectorAll("text.unit-note")) {
      e.textContent = e.textContent.replace(/^lengths in \w+/, `lengths in ${this.unit}`);
    }
    for (const e of root.querySelectorAll("data[value]")) {
      const value = Number(e.value);
      if (e.classList.contains("mm")) e.textContent = this.length(value);
      else if (e.classList.contains("s")) e.textContent = this.plain(value, 1, 1);
      else e.textContent = this.plain(value, 3);
    }
    for (const e of root.querySelectorAll(".unit")) {
      e.textContent = e.dataset.per ? `${this.unit}/${e.dataset.per}` : this.unit;
    }
  },
};
