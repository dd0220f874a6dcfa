// A head over a table: the whole way pale, what is done in the colours of its speed.
class Table {
  constructor(data, trace) {
    this.trace = trace;
    this.colours = Trace.spread(data.colours, trace.count);
    this.on = trace.states.map((s) => s.process !== "");
    const [x, y] = trace.places;
    const low = (p) => p.reduce((a, b) => Math.min(a, b)) / 1000;
    const high = (p) => p.reduce((a, b) => Math.max(a, b)) / 1000;
    this.box = [low(x), low(y), high(x), high(y)];
    this.chunks = null;
    this.fitted = "";
  }

  // Runs of intervals of one colour, as paths that are made once for a size of the canvas.
  prepare(view) {
    const size = `${view.wide} ${view.high}`;
    if (this.fitted === size) return;
    this.fitted = size;
    const [x0, y0, x1, y1] = this.box, edge = 22;
    const scale = Math.min((view.wide - 2 * edge) / Math.max(x1 - x0, 1e-6),
      (view.high - 2 * edge) / Math.max(y1 - y0, 1e-6));
    const left = (view.wide - scale * (x1 - x0)) / 2, top = (view.high - scale * (y1 - y0)) / 2;
    this.at = (x, y) => [left + (x - x0) * scale, view.high - top - (y - y0) * scale];
    const { places, state, count } = this.trace, [px, py] = places;
    this.chunks = [];
    const style = (k) => (this.on[state[k]] ? this.colours[k] : -1);
    let k = 0;
    while (k < count) {
      const first = k, kind = style(k), path = new Path2D();
      path.moveTo(...this.at(px[k] / 1000, py[k] / 1000));
      while (k < count && k - first < 400 && style(k) === kind) {
        k++;
        path.lineTo(...this.at(px[k] / 1000, py[k] / 1000));
      }
      this.chunks.push({ first, last: k, kind, path });
    }
  }

  stroke(pen, path, kind, ahead) {
    pen.strokeStyle = ahead ? Colours.pale : kind < 0 ? Colours.rapid : Colours.speed[kind];
    pen.lineWidth = ahead ? 1 : kind < 0 ? 1 : 2.2;
    pen.setLineDash(kind < 0 ? [4, 3] : []);
    pen.stroke(path);
  }

  draw(view, t) {
    view.fit();
    this.prepare(view);
    const now = this.trace.count ? this.trace.interval(t) : 0;
    const pen = view.pen;
    for (const c of this.chunks) if (c.last > now) this.stroke(pen, c.path, c.kind, true);
    for (const c of this.chunks) if (c.last <= now) this.stroke(pen, c.path, c.kind, false);
    const under = this.chunks.find((c) => c.first <= now && now < c.last);
    const [x, y] = this.trace.positions(t);
    const here = this.at(x, y);
    if (under) {
      const path = new Path2D(), [px, py] = this.trace.places;
      path.moveTo(...this.at(px[under.first] / 1000, py[under.first] / 1000));
      for (let k = under.first + 1; k <= now; k++) {
        path.lineTo(...this.at(px[k] / 1000, py[k] / 1000));
      }
      path.lineTo(...here);
      this.stroke(pen, path, under.kind, false);
    }
    const process = this.trace.stateAt(t).process;
    view.circle(here, process ? 6 : 5, process ? Colours.work : Colours.ink,
      process ? Colours.work : Colours.paper, 2);
    view.chain([[here[0], here[1] - 14], [here[0], here[1] + 14]], Colours.ink);
    view.chain([[here[0] - 14, here[1]], [here[0] + 14, here[1]]], Colours.ink);
  }
}
