// The cell with its bar: from above, from the side, and as a wireframe in space.
//
// Along the rollers a place of the bar lies at its bar x less the position of the stop; saw and
// drills stand still. y runs across the web, z from below upwards; v faces up.
class Cell {
  constructor(data, trace) {
    Object.assign(this, data);
    this.trace = trace;
    this.cutDone = data.cuts.map((c) => trace.over.get(c.line) ?? 0);
    this.holes = data.bores.map((b) => ({ ...b, done: trace.over.get(b.line) ?? 0 }));
    this.paths = data.trails.map((t) => ({ ...t, done: trace.over.get(t.line) ?? 0 }));
    this.whole = false;
    this.yaw = -0.6;
    this.pitch = 0.5;
  }

  // All that the views need at a time.
  at(t) {
    const axes = this.trace.positions(t), state = this.trace.stateAt(t);
    const stop = this.stop === null ? 0 : axes[this.stop];
    const rotation = this.saw.rotation === null ? this.saw.zero_angle : axes[this.saw.rotation];
    const mitre = (this.saw.sign * (rotation - this.saw.zero_angle) * Math.PI) / 180;
    const down = this.saw.stroke === null ? 0 : axes[this.saw.stroke];
    const spindles = this.spindles.map((s) => ({
      ...s,
      at: s.y[0] + s.y[1] * (s.across === null ? 0 : axes[s.across]),
      deep: s.depth[0] + s.depth[1] * (s.stroke === null ? 0 : axes[s.stroke]),
      chosen: s.numbers.includes(state.spindle),
      turning: s.numbers.includes(state.spindle) && state.turning !== 0,
    }));
    return { t, stop, mitre, down, spindles, state };
  }

  // The stretch of rollers that is shown.
  window() {
    const stop = this.stop === null ? null : this.trace.places[this.stop];
    if (!this.whole || !stop) {
      const middle = (this.saw.x + this.drill) / 2;
      const half = Math.max(900, 0.75 * Math.abs(this.saw.x - this.drill) + 500);
      return [middle - half, middle + half];
    }
    const low = stop.reduce((a, b) => Math.min(a, b)) / 1000;
    const high = stop.reduce((a, b) => Math.max(a, b)) / 1000;
    return [Math.min(this.saw.x, this.drill, -high) - 100,
      Math.max(this.saw.x, this.drill, this.bar - low) + 100];
  }

  // The corners of a piece's end at an edge of the section: 0 lower, 1 upper; by y and z.
  static edge(ends, y, z) {
    return ends[2 * y + z];
  }

  drawFlat(view, now, above) {
    view.fit();
    const { height, width } = this.section;
    const across = above ? height : width;
    const [first, last] = this.window();
    const room = 74;
    // One scale for both views, so that what is above each other belongs together.
    const largest = Math.max(height, width);
    const whole = Math.min(view.wide / (last - first), (view.high - 2 * room) / largest);
    const middle = (first + last) / 2, scale = whole * view.zoom;
    const at = (x, across_) => view.seen([
      view.wide / 2 + (x - middle) * whole,
      view.high / 2 - (across_ - across / 2) * whole,
    ]);
    this.drawBar(view, now, above, at);
    this.drawMade(view, now, above, at, scale);
    this.drawSaw(view, now, above, at);
    for (const spindle of now.spindles) this.drawSpindle(view, now, above, at, scale, spindle);
    const known = this.section.assumed ? "; the section is not known" : "";
    view.text((above ? "from above" : "from the side") + known, 8, 16, Colours.ink);
    this.drawLabels(view, at, across);
  }

  drawLabels(view, at, across) {
    const saw = at(this.saw.x, across), drill = at(this.drill, across);
    view.text("saw", saw[0], 30, Colours.ink, "center");
    view.text("drills", drill[0], 30, Colours.ink, "center");
  }

  // The bar, and the parts that are cut off on both sides in another colour.
  drawBar(view, now, above, at) {
    for (const [k, piece] of this.pieces.entries()) {
      const [y0, z0, y1, z1] = above ? [0, 1, 1, 1] : [0, 0, 0, 1];
      const corner = (ends, y, z) => Cell.edge(ends, y, z) - now.stop;
      const { height, width } = this.section;
      const low = 0, high = above ? height : width;
      const points = [
        at(corner(piece.start, y0, z0), low), at(corner(piece.end, y0, z0), low),
        at(corner(piece.end, y1, z1), high), at(corner(piece.start, y1, z1), high),
      ];
      const before = k ? this.cutDone[k - 1] : -1;
      const behind = k < this.cutDone.length ? this.cutDone[k] : Infinity;
      const free = piece.kind === "part" && now.t >= before && now.t >= behind;
      view.chain(points, Colours.line, this.section.assumed ? { dash: [6, 4], closed: true }
        : { fill: free ? Colours.part : Colours.steel, closed: true });
      if (above && piece.mark) {
        const x = (points[0][0] + points[1][0]) / 2;
        if (points[1][0] - points[0][0] > 30) {
          view.text(piece.mark, x, at(0, 0)[1] + 14, Colours.ink, "center");
        }
      }
    }
    for (const [k, cut] of this.cuts.entries()) {
      if (now.t < this.cutDone[k]) continue;
      const [a, b] = above ? [cut.x[0], cut.x[1]] : [cut.x[2], cut.x[3]];
      const high = above ? this.section.height : this.section.width;
      view.chain([at(a - now.stop, 0), at(b - now.stop, high)], Colours.cut, { width: 2 });
    }
  }

  // The holes and paths that are made by now.
  drawMade(view, now, above, at, scale) {
    const { height, width } = this.section;
    for (const hole of this.holes) {
      if (now.t < hole.done) continue;
      const x = hole.x - now.stop, r = hole.d / 2, [left] = at(x - r, 0), [right] = at(x + r, 0);
      if (right < 0 || left > view.wide) continue; // not in the window
      if (above === (hole.face === "v" || hole.face === "h")) {
        const dim = hole.face === "h" || hole.face === "o";
        view.circle(at(x, hole.y), r * scale, dim ? Colours.rapid : Colours.tool, Colours.paper);
      } else {
        const high = { v: width, o: height, h: 0, u: 0 }[hole.face];
        const deep = { v: -1, o: -1, h: 1, u: 1 }[hole.face] * 18;
        view.chain([at(x - r, high), at(x - r, high + deep)], Colours.tool);
        view.chain([at(x + r, high), at(x + r, high + deep)], Colours.tool);
      }
    }
    for (const path of this.paths) {
      if (now.t < path.done || above !== (path.face === "v" || path.face === "h")) continue;
      view.chain(path.points.map(([x, y]) => at(x - now.stop, y)), Colours.tool, { width: 2 });
    }
  }

  drawSaw(view, now, above, at) {
    const { height, width } = this.section;
    const colour = now.state.sawing ? Colours.work : Colours.ink;
    const thick = now.state.sawing ? 4 : 2;
    const rise = (y) => (this.saw.pivot === "o" ? y - height : y);
    const x = (y) => this.saw.x - rise(y) * Math.tan(now.mitre);
    if (above) {
      view.chain([at(x(-40), -40), at(x(height + 40), height + 40)], colour,
        { width: thick, dash: now.state.sawing ? [] : [6, 4] });
      return;
    }
    const lower = width + 20 - now.down;
    view.chain([at(x(height / 2), width + 200), at(x(height / 2), lower)], colour, { width: 6 });
  }

  drawSpindle(view, now, above, at, scale, s) {
    const { height, width } = this.section;
    const colour = s.turning ? Colours.work : s.chosen ? Colours.tool : Colours.rapid;
    const radius = s.chosen && now.state.diameter ? now.state.diameter / 2 : 10;
    const onFace = above === (s.face === "v" || s.face === "h");
    if (onFace) {
      const fill = s.turning && s.deep > 0 ? colour : null;
      view.circle(at(this.drill, s.at), Math.max(radius * scale, 4), colour, fill, 2);
      return;
    }
    const [edge, out] = { v: [width, 1], o: [height, 1], h: [0, -1], u: [0, -1] }[s.face];
    const tip = edge - out * s.deep, r = Math.max(radius, 2 / scale);
    view.chain([
      at(this.drill - r, tip + out * 140), at(this.drill - r, tip + out * r),
      at(this.drill, tip), at(this.drill + r, tip + out * r), at(this.drill + r, tip + out * 140),
    ], colour, { fill: s.turning ? colour : null, width: 1.5, closed: true });
  }

  // The pieces as edges in space, the tools as lines.
  drawSpace(view, now) {
    view.fit();
    const { height, width, outlines } = this.section;
    const [first, last] = this.window();
    const middle = (first + last) / 2;
    const scale = (0.95 * view.wide) / (last - first);
    const [cy, sy] = [Math.cos(this.yaw), Math.sin(this.yaw)];
    const [cp, sp] = [Math.cos(this.pitch), Math.sin(this.pitch)];
    const at = (x, y, z) => {
      const a = x - middle, b = y - height / 2, c = z - width / 2;
      const right = cy * a - sy * b, deep = sy * a + cy * b;
      return view.seen([view.wide / 2 + scale * right,
        view.high / 2 - scale * (cp * c + sp * deep)]);
    };
    const corner = (ends, y, z) => {
      const [a, b, c, d] = ends, u = y / height, w = z / width;
      return (a * (1 - w) + b * w) * (1 - u) + (c * (1 - w) + d * w) * u;
    };
    for (const [k, piece] of this.pieces.entries()) {
      const done = (k === 0 || now.t >= this.cutDone[k - 1]) &&
        (k >= this.cutDone.length || now.t >= this.cutDone[k]);
      const colour = piece.kind === "part" && done ? Colours.done : Colours.line;
      for (const outline of outlines) {
        const ends = [piece.start, piece.end].map((end) =>
          outline.map(([z, y]) => at(corner(end, y, z) - now.stop, y, z)));
        const dash = this.section.assumed ? [6, 4] : [];
        for (const end of ends) view.chain(end, colour, { closed: true, dash });
        outline.forEach((_, i) => view.chain([ends[0][i], ends[1][i]], colour, { dash }));
      }
    }
    for (const hole of this.holes) {
      if (now.t < hole.done) continue;
      const ring = [];
      for (let k = 0; k <= 12; k++) {
        const x = hole.x - now.stop + (hole.d / 2) * Math.cos((k * Math.PI) / 6);
        const across = hole.y + (hole.d / 2) * Math.sin((k * Math.PI) / 6);
        ring.push({
          v: () => at(x, across, width), h: () => at(x, across, 0),
          o: () => at(x, height, across), u: () => at(x, 0, across),
        }[hole.face]());
      }
      view.chain(ring, Colours.tool);
    }
    const saw = now.state.sawing ? Colours.work : Colours.ink;
    const rise = (y) => (this.saw.pivot === "o" ? y - height : y);
    const x = (y) => this.saw.x - rise(y) * Math.tan(now.mitre);
    const low = width + 20 - now.down;
    view.chain([at(x(-60), -60, low), at(x(height + 60), height + 60, low),
      at(x(height + 60), height + 60, low + 260), at(x(-60), -60, low + 260)], saw,
    { width: now.state.sawing ? 3 : 1.5, closed: true });
    for (const s of now.spindles) {
      const colour = s.turning ? Colours.work : s.chosen ? Colours.tool : Colours.rapid;
      const [tip, back] = {
        v: [at(this.drill, s.at, width - s.deep), at(this.drill, s.at, width - s.deep + 180)],
        h: [at(this.drill, s.at, s.deep), at(this.drill, s.at, s.deep - 180)],
        o: [at(this.drill, height - s.deep, s.at), at(this.drill, height - s.deep + 180, s.at)],
        u: [at(this.drill, s.deep, s.at), at(this.drill, s.deep - 180, s.at)],
      }[s.face];
      view.chain([back, tip], colour, { width: s.turning ? 4 : 2 });
    }
    view.text("in space", 8, 16, Colours.ink);
  }
}
