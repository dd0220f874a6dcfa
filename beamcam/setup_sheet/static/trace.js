// Where the axes are at a time. The form of the data: beamcam/setup_sheet/playback.py.
class Trace {
  constructor(data) {
    const n = data.t.length;
    this.axes = data.axes;
    this.states = data.states;
    this.count = n;
    this.time = new Float64Array(n + 1);
    let micro = 0;
    for (let k = 0; k < n; k++) {
      micro += data.t[k];
      this.time[k + 1] = micro / 1e6;
    }
    this.places = data.p.map((column, axis) => Trace.summed(column, data.start[axis], n));
    this.slopes = data.s;
    this.line = new Int32Array(n);
    let line = 0;
    for (let k = 0; k < n; k++) this.line[k] = line += data.l[k];
    this.state = Trace.spread(data.o, n);
    this.over = new Map(); // line -> when its last interval is over
    this.begin = new Map(); // line -> when its first interval begins
    for (let k = 0; k < n; k++) {
      this.over.set(this.line[k], this.time[k + 1]);
      if (!this.begin.has(this.line[k])) this.begin.set(this.line[k], this.time[k]);
    }
  }

  static summed(column, start, n) {
    const found = new Float64Array(n + 1);
    let at = start, k = 1;
    found[0] = at;
    for (const step of column) {
      const [value, times] = Array.isArray(step) ? step : [step, 1];
      for (let i = 0; i < times; i++) found[k++] = at += value;
    }
    return found;
  }

  static spread(runs, n) {
    const found = new Int32Array(n);
    let k = 0;
    for (const [value, times] of runs) {
      found.fill(value, k, k + times);
      k += times;
    }
    return found;
  }

  get duration() {
    return this.time[this.count];
  }

  // The interval at a time, the later one where two meet.
  interval(t) {
    let low = 0, high = this.count - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.time[middle] <= t) low = middle;
      else high = middle - 1;
    }
    return Math.max(0, low);
  }

  // How much of the way of an interval is done at a time (Hermite).
  share(k, t) {
    const lasts = this.time[k + 1] - this.time[k];
    if (!(lasts > 0)) return 1;
    const u = Math.min(1, Math.max(0, (t - this.time[k]) / lasts));
    const slopes = this.slopes[k];
    const a = slopes ? slopes[0] / 1000 : 1, b = slopes ? slopes[1] / 1000 : 1;
    return u * (a + u * (3 - 2 * a - b + u * (a + b - 2)));
  }

  // Position of an axis at a time, mm or degrees.
  place(axis, t, k = this.interval(t), share = this.share(k, t)) {
    const p = this.places[axis];
    return (p[k] + share * (p[k + 1] - p[k])) / 1000;
  }

  positions(t) {
    if (!this.count) return this.places.map((p) => p[0] / 1000);
    const k = this.interval(t), share = this.share(k, t);
    return this.places.map((_, axis) => this.place(axis, t, k, share));
  }

  lineAt(t) {
    return this.count ? this.line[this.interval(t)] : 0;
  }

  stateAt(t) {
    return this.states[this.count ? this.state[this.interval(t)] : 0];
  }

  // When the block before or behind the one at a time begins; the ends of the trace else.
  step(t, way) {
    let k = this.interval(t);
    const line = this.line[k];
    if (way > 0) {
      while (k < this.count && this.line[k] === line) k++;
      return this.time[k];
    }
    while (k > 0 && this.line[k - 1] === line) k--;
    if (t > this.time[k] + 1e-9 || k === 0) return this.time[k];
    const before = this.line[k - 1];
    while (k > 0 && this.line[k - 1] === before) k--;
    return this.time[k];
  }
}
