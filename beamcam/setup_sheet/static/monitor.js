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

// A head over its table, with the way that it has gone since the page was opened.
class LiveTable {
  constructor(data, trace) {
    this.trace = trace;
    this.way = [];
  }

  draw(view) {
    view.fit();
    const [x, y] = this.trace.positions(), last = this.way[this.way.length - 1];
    if (!last || last[0] !== x || last[1] !== y) this.way.push([x, y]);
    if (this.way.length > 20000) this.way.splice(0, 10000);
    const [px, py] = this.trace.places, edge = 22;
    const wide = Math.max(px[1] - px[0], 1) / 1000, high = Math.max(py[1] - py[0], 1) / 1000;
    const scale = Math.min((view.wide - 2 * edge) / wide, (view.high - 2 * edge) / high);
    const at = ([a, b]) => [edge + (a - px[0] / 1000) * scale,
      view.high - edge - (b - py[0] / 1000) * scale];
    const [x0, y0, x1, y1] = [px[0], py[0], px[1], py[1]].map((p) => p / 1000);
    view.chain([[x0, y0], [x1, y0], [x1, y1], [x0, y1]].map(at), Colours.pale, { closed: true });
    view.chain(this.way.map(at), Colours.tool, { width: 2 });
    const on = this.trace.stateAt().process || this.trace.stateAt().sawing;
    view.circle(at([x, y]), 6, on ? Colours.work : Colours.ink, on ? Colours.work : null, 2);
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
    for (const { name, view } of Sheet.views) if (name === "space") Sheet.turnable(view.canvas);
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
    for (const { name, view } of Sheet.views) {
      if (!view.canvas.clientWidth) continue;
      if (Sheet.data.kind !== "bar") Sheet.model.draw(view, 0);
      else if (name === "space") Sheet.model.drawSpace(view, Sheet.model.at(0));
      else Sheet.model.drawFlat(view, Sheet.model.at(0), name === "above");
    }
    Sheet.tell(0);
    const line = Sheet.trace.now.line;
    document.getElementById("line").textContent = line ? `block ${line}` : "";
  },
};

Monitor.start();
