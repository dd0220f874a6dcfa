// A carriage on its guide, under the profile of its velocity.
class Guide {
  constructor(data, trace) {
    this.trace = trace;
    this.labels = data.labels;
    this.samples = data.samples; // [time, velocity]
    this.high = Math.max(...this.samples.map(([, v]) => v), 0);
    this.low = Math.min(...this.samples.map(([, v]) => v), 0);
    const places = trace.places[0];
    this.first = places.reduce((a, b) => Math.min(a, b)) / 1000;
    this.last = places.reduce((a, b) => Math.max(a, b)) / 1000;
  }

  draw(view, t) {
    view.fit();
    const left = 16, right = view.wide - 16, top = 26, bottom = view.high - 92;
    const end = this.trace.duration || 1, span = this.high - this.low || 1;
    const at = (time, v) => [left + (time / end) * (right - left),
      bottom - ((v - this.low) / span) * (bottom - top)];
    view.chain([at(0, 0), at(end, 0)], Colours.pale);
    view.chain(this.samples.map(([time, v]) => at(time, v)), Colours.tool, { width: 2 });
    view.chain([at(t, this.low), at(t, this.high)], Colours.work, { width: 2 });
    const speed = this.samples.reduce((v, s) => (s[0] <= t ? s[1] : v), 0);
    view.text(`${this.labels[1]}: ${Numbers.plain(speed, 1)} of ${Numbers.plain(this.high, 1)}`,
      left, 16, Colours.ink);
    const rail = view.high - 36;
    view.chain([[left, rail], [right, rail]], Colours.ink, { width: 4 });
    const [x] = this.trace.positions(t);
    const share = (x - this.first) / (this.last - this.first || 1);
    const place = left + 24 + share * (right - left - 48);
    view.chain([[place - 24, rail - 26], [place + 24, rail - 26], [place + 24, rail - 3],
      [place - 24, rail - 3]], Colours.ink, { fill: Colours.part, closed: true });
    const edge = (x) => Numbers.plain(x, 1);
    view.text(edge(this.first), left, rail + 20, Colours.ink);
    view.text(`${edge(this.last)}; ${this.labels[0]}`, right, rail + 20, Colours.ink, "right");
    view.text(`${edge(t)} s`, at(t, 0)[0], bottom + 16, Colours.ink, "center");
  }
}
