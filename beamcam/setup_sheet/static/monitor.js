// The axes of a controller while they move, drawn as the playback draws a trace.
class Live {
  constructor(data) {
    this.axes = data.axes;
    this.count = 0;
    this.now = { positions: data.axes.map(() => 0), state: data.state, line: 0 };
    // The range that a view shows, in thousandths as in a trace.
    this.places = data.axes.map((a) => [1000 * (a.min ?? 0), 1000 * (a.max ?? 1000)]);
    this.begin = new Map();
    this.duration = 0;
    // What a block makes is made when the controller shows a later one: blocks stand for times.
    this.over = { get: (line) => line + 0.5 };
  }

  positions() {
    return this.now.positions;
  }

  stateAt() {
    return this.now.state;
  }

  lineAt() {
    return this.now.line;
  }
}

// A head over its table, with the way that it has gone since the page was opened; under it the
// program's way, where it is known.
class LiveTable {
  constructor(data, trace) {
    this.trace = trace;
    this.path = data.path;
    this.way = [];
    this.whole = false;
    const points = data.path.flat();
    const range = (k) => points.map((p) => p[k])
      .reduce(([a, b], v) => [Math.min(a, v), Math.max(b, v)], [Infinity, -Infinity]);
    this.box = points.length ? [range(0), range(1)] : null;
  }

  // What is shown of X and of Y: the table, or the program's way with a margin.
  window() {
    if (this.whole || !this.box) return this.trace.places.map(([a, b]) => [a / 1000, b / 1000]);
    const room = 0.05 * Math.max(...this.box.map(([a, b]) => b - a), 1);
    return this.box.map(([a, b]) => [a - room, b + room]);
  }

  draw(view) {
    view.fit();
    const [x, y] = this.trace.positions(), last = this.way[this.way.length - 1];
    const state = this.trace.stateAt(), on = Boolean(state.process || state.sawing);
    if (!last || last[0] !== x || last[1] !== y) this.way.push([x, y, on]);
    if (this.way.length > 20000) this.way.splice(0, 10000);
    const [[x0, x1], [y0, y1]] = this.window(), edge = 26;
    const scale = Math.min((view.wide - 2 * edge) / Math.max(x1 - x0, 1e-3),
      (view.high - 2 * edge) / Math.max(y1 - y0, 1e-3));
    const left = (view.wide - scale * (x1 - x0)) / 2, top = (view.high - scale * (y1 - y0)) / 2;
    const at = ([a, b]) => [left + (a - x0) * scale, view.high - top - (b - y0) * scale];
    const [[a, b], [c, d]] = this.trace.places.map((p) => p.map((v) => v / 1000));
    view.chain([[a, c], [b, c], [b, d], [a, d]].map(at), Colours.rapid, { closed: true });
    for (const chain of this.path) view.chain(chain.map(at), Colours.line);
    for (let k = 1; k < this.way.length; k++) {
      const tool = this.way[k][2];
      view.chain([at(this.way[k - 1]), at(this.way[k])], tool ? Colours.work : Colours.tool,
        { width: tool ? 2.5 : 1.5, dash: tool ? [] : [4, 3] });
    }
    const here = at([x, y]);
    view.circle(here, 6, on ? Colours.work : Colours.ink, on ? Colours.work : Colours.paper, 2);
    const corner = ([p, q]) => `${Numbers.length(p)}, ${Numbers.length(q)}`;
    const [p, q] = this.whole || !this.box ? [[a, c], [b, d]]
      : [0, 1].map((k) => this.box.map((range) => range[k]));
    view.text(corner(p), at(p)[0], at(p)[1] + 16, Colours.ink);
    view.text(`${corner(q)} ${Numbers.unit}`, at(q)[0], at(q)[1] - 8, Colours.ink, "right");
  }
}

const Monitor = {
  start() {
    const data = JSON.parse(document.getElementById("monitor").textContent);
    this.every = data.every;
    Sheet.data = data;
    Sheet.trace = new Live(data);
    Sheet.model = data.kind === "bar" ? new Cell(data, Sheet.trace)
      : new LiveTable(data, Sheet.trace);
    Sheet.views = [...document.querySelectorAll("canvas[data-view]")]
      .map((canvas) => ({ name: canvas.dataset.view, view: new View(canvas) }));
    for (const { name, view } of Sheet.views) if (name === "space") Sheet.turnable(view.canvas, view);
    const whole = document.getElementById("whole"), box = document.getElementById("listing");
    whole.addEventListener("change", () => {
      Sheet.model.whole = whole.checked;
      Sheet.draw();
    });
    if (box) Sheet.listing = new Listing(box, Sheet.program.lines, () => {});
    Sheet.draw = () => this.draw();
    window.addEventListener("resize", () => this.draw());
    this.ask();
  },

  async ask() {
    try {
      const answer = await fetch("axes", { cache: "no-store" });
      const said = await answer.json();
      if (said.positions) Sheet.trace.now = said;
      this.say(said.fault ? `No answer from the controller: ${said.fault}` : "", said.reads);
    } catch {
      this.say("beamcam monitor has ended.", null);
    }
    this.draw();
    setTimeout(() => this.ask(), this.every);
  },

  say(fault, reads) {
    const box = document.getElementById("link");
    box.dataset.state = fault ? "differs" : "same";
    box.textContent = fault || `Connected: ${reads} readings.`;
  },

  draw() {
    const line = Sheet.trace.now.line;
    for (const { name, view } of Sheet.views) {
      if (!view.canvas.clientWidth) continue;
      if (Sheet.data.kind !== "bar") Sheet.model.draw(view, 0);
      else if (name === "space") Sheet.model.drawSpace(view, Sheet.model.at(line));
      else Sheet.model.drawFlat(view, Sheet.model.at(line), name === "above");
    }
    Sheet.tell(0);
    if (Sheet.listing) Sheet.listing.show(line);
    document.getElementById("line").textContent = line ? `block ${line}` : "";
  },
};

Monitor.start();
