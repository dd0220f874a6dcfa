// A head over a table: the whole way pale, what is done in the colours of its speed.
//
// What is done lies in a layer of its own, to which a frame adds what is new. All of it is drawn
// again only where time goes back, or the window changes.
class Table {
  constructor(data, trace) {
    this.trace = trace;
    this.colours = Trace.spread(data.colours, trace.count);
    this.on = trace.states.map((s) => s.process !== "");
    const [x, y] = trace.places;
    const low = (p) => p.reduce((a, b) => Math.min(a, b)) / 1000;
    const high = (p) => p.reduce((a, b) => Math.max(a, b)) / 1000;
    this.box = [low(x), low(y), high(x), high(y)];
    this.layer = document.createElement("canvas");
    this.pen = this.layer.getContext("2d");
    this.until = 0; // the interval up to which the layer is drawn
    this.key = "";
    this.drawn = 0; // intervals drawn, for who counts them
  }

  style(k) {
    return this.on[this.trace.state[k]] ? this.colours[k] : -1;
  }

  // The intervals from one to another in the layer; `ahead` those that are to come.
  add(first, last, ahead) {
    const [px, py] = this.trace.places;
    let k = first;
    while (k < last) {
      const kind = this.style(k), path = new Path2D(), begin = k;
      path.moveTo(...this.at(px[k] / 1000, py[k] / 1000));
      while (k < last && k - begin < 400 && this.style(k) === kind) {
        k++;
        path.lineTo(...this.at(px[k] / 1000, py[k] / 1000));
      }
      this.stroke(this.pen, path, kind, ahead);
    }
    this.drawn += Math.max(0, last - first);
  }

  stroke(pen, path, kind, ahead) {
    pen.strokeStyle = ahead ? Colours.pale : kind < 0 ? Colours.rapid : Colours.speed[kind];
    pen.lineWidth = ahead ? 1 : kind < 0 ? 1 : 2.2;
    pen.setLineDash(kind < 0 ? [4, 3] : []);
    pen.stroke(path);
  }

  // The layer for the window as it is, done up to an interval.
  prepare(view, now) {
    const key = [view.wide, view.high, view.zoom, ...view.shift, Colours.paper].join(" ");
    if (key === this.key && now >= this.until) {
      this.add(this.until, now, false);
      this.until = now;
      return;
    }
    this.key = key;
    const [x0, y0, x1, y1] = this.box, edge = 22;
    const scale = Math.min((view.wide - 2 * edge) / Math.max(x1 - x0, 1e-6),
      (view.high - 2 * edge) / Math.max(y1 - y0, 1e-6));
    const left = (view.wide - scale * (x1 - x0)) / 2, top = (view.high - scale * (y1 - y0)) / 2;
    this.at = (x, y) => view.seen([left + (x - x0) * scale, view.high - top - (y - y0) * scale]);
    [this.layer.width, this.layer.height] = [view.canvas.width, view.canvas.height];
    const ratio = this.layer.width / view.wide;
    this.pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.add(0, this.trace.count, true);
    this.add(0, now, false);
    this.until = now;
  }

  draw(view, t) {
    view.fit();
    const now = this.trace.count ? this.trace.interval(t) : 0;
    this.prepare(view, now);
    if (this.layer.width && this.layer.height) {
      view.pen.drawImage(this.layer, 0, 0, view.wide, view.high);
    }
    const here = this.at(...this.trace.positions(t));
    if (this.trace.count) {
      const path = new Path2D(), [px, py] = this.trace.places;
      path.moveTo(...this.at(px[now] / 1000, py[now] / 1000));
      path.lineTo(...here);
      this.stroke(view.pen, path, this.style(now), false);
    }
    const process = this.trace.stateAt(t).process;
    view.circle(here, process ? 6 : 5, process ? Colours.work : Colours.ink,
      process ? Colours.work : Colours.paper, 2);
    view.chain([[here[0], here[1] - 14], [here[0], here[1] + 14]], Colours.ink);
    view.chain([[here[0] - 14, here[1]], [here[0] + 14, here[1]]], Colours.ink);
  }
}
