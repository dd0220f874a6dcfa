// The page: playback, the program's text, the pictures and the tables joined together.
const Sheet = {
  start() {
    const read = (id) => {
      const e = document.getElementById(id);
      return e ? JSON.parse(e.textContent) : null;
    };
    this.data = read("playback");
    this.program = read("program");
    if (this.program && this.program.text !== null) {
      this.program.lines = this.program.text.split("\n");
    }
    this.time = 0;
    this.playing = false;
    this.speed = 1;
    Numbers.unit = document.documentElement.dataset.unit;
    this.checkHash();
    Colours.read();
    this.units();
    if (this.data) this.playback();
    const solid = read("solid");
    this.ready = solid ? this.space(solid) : null;
    Numbers.show(document);
  },

  // The solid, and the faces that its operations are on.
  async space(data) {
    const box = this.one("solid-view");
    let pieces;
    try {
      pieces = await Promise.all(data.pieces.map((piece) => Mesh.unpacked(piece)));
    } catch {
      box.textContent = "This browser is too old to unpack the solid.";
      return;
    }
    this.solid = new Solid(box, data, pieces, (line) => this.pick(line));
    this.faces = new Map((this.data?.bores ?? []).concat(this.data?.trails ?? [])
      .map(({ line, face }) => [line, face]).reverse()); // of two spindles the first
    window.addEventListener("resize", () => this.solid.draw());
    // On paper it is as light as the paper.
    for (const media of ["(prefers-color-scheme: dark)", "print"]) {
      window.matchMedia(media).addEventListener("change", () => {
        Colours.read();
        if (media === "print") this.solid.fit(); // its size is another
        else this.solid.draw();
      });
    }
  },

  one(id) {
    return document.getElementById(id);
  },

  // Whether the program that the page holds is the one that it was made of.
  checkHash() {
    const box = this.one("hash");
    const wanted = document.documentElement.dataset.sha256;
    if (!box) return;
    if (this.program && this.program.text !== null) {
      const found = sha256(new TextEncoder().encode(this.program.text));
      box.dataset.state = found === wanted ? "same" : "differs";
      this.one("hash-said").textContent = found === wanted
        ? "The program in this page is the one that was read back."
        : `The program in this page was changed: its SHA-256 is ${found}.`;
    }
    this.one("program-file").addEventListener("change", async (event) => {
      const file = event.target.files[0];
      if (!file) return;
      const found = sha256(new Uint8Array(await file.arrayBuffer()));
      box.dataset.state = found === wanted ? "same" : "differs";
      this.one("hash-said").textContent = found === wanted
        ? `${file.name} is the program of this sheet.`
        : `${file.name} is another program: its SHA-256 is ${found}.`;
    });
  },

  units() {
    const choice = this.one("unit");
    if (!choice) return;
    choice.value = Numbers.unit;
    choice.addEventListener("change", () => {
      Numbers.unit = choice.value;
      Numbers.show(document);
      this.draw();
    });
  },

  playback() {
    this.trace = new Trace(this.data.trace);
    const kinds = { bar: Cell, table: Table, guide: Guide };
    this.model = new kinds[this.data.kind](this.data, this.trace);
    this.views = [...document.querySelectorAll("canvas[data-view]")]
      .map((canvas) => ({ name: canvas.dataset.view, view: new View(canvas) }));
    const box = this.one("listing");
    if (box && this.program) {
      this.listing = new Listing(box, this.program.lines, (line, way = 1) => this.pick(line, way));
    }
    this.operations = (this.data.operations ?? [])
      .filter(({ line }) => this.trace.begin.has(line))
      .map((op) => ({ ...op, begin: this.trace.begin.get(op.line) }))
      .sort((a, b) => a.begin - b.begin);
    this.controls();
    this.marks();
    this.pictures();
    this.draw();
    window.addEventListener("resize", () => this.draw());
    window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
      Colours.read();
      this.draw();
    });
  },

  controls() {
    const slider = this.one("time");
    slider.max = this.trace.duration;
    slider.addEventListener("input", () => this.go(Number(slider.value)));
    this.one("play").addEventListener("click", () => this.play(!this.playing));
    this.one("first").addEventListener("click", () => this.go(0));
    this.one("back").addEventListener("click", () => this.go(this.trace.step(this.time, -1)));
    this.one("forward").addEventListener("click", () => this.go(this.trace.step(this.time, 1)));
    this.one("speed").addEventListener("change", (event) => {
      this.speed = Number(event.target.value);
    });
    const whole = this.one("whole");
    if (whole) {
      whole.addEventListener("change", () => {
        this.model.whole = whole.checked;
        this.draw();
      });
    }
    document.addEventListener("keydown", (event) => this.key(event));
    // A button that the mouse has pressed gives the keys back to the page.
    document.addEventListener("click", (event) => {
      const button = event.target.closest("button");
      if (button && event.detail > 0) button.blur();
    });
    this.looking();
    for (const button of document.querySelectorAll("button[data-line]")) {
      button.addEventListener("click", () => {
        const line = Number(button.dataset.line);
        this.pick(line);
        if (!this.solid) return;
        this.solid.show(line, true, this.faces.get(line));
        this.solid.box.scrollIntoView({ block: "nearest" });
      });
    }
  },

  // Which view is seen; nearer, further off, to a side and round.
  looking() {
    const show = (name) => {
      for (const { name: other, view } of this.views) view.canvas.hidden = other !== name;
      for (const button of document.querySelectorAll("button[data-show]")) {
        button.setAttribute("aria-pressed", button.dataset.show === name);
      }
      this.draw();
    };
    for (const button of document.querySelectorAll("button[data-show]")) {
      button.addEventListener("click", () => show(button.dataset.show));
    }
    const change = (view, does) => () => {
      does(view);
      this.draw();
    };
    const now = () => this.views.find(({ view }) => view.canvas.clientWidth)?.view;
    const does = { in: (v) => v.nearer(1.4), out: (v) => v.nearer(1 / 1.4), fit: (v) => v.home() };
    for (const button of document.querySelectorAll("button[data-zoom]")) {
      button.addEventListener("click", () => change(now(), does[button.dataset.zoom])());
    }
    for (const { name, view } of this.views) {
      if (name === "space") this.turnable(view.canvas, view);
      else if (name !== "guide") {
        Gestures.on(view.canvas, {
          drag: (dx, dy) => change(view, (v) => v.move(dx, dy))(),
          move: (dx, dy) => change(view, (v) => v.move(dx, dy))(),
          zoom: (by, x, y) => change(view, (v) => v.nearer(by, x, y))(),
        });
      }
      view.canvas.addEventListener("keydown", (event) => {
        const by = { "+": does.in, "-": does.out, 0: does.fit }[event.key];
        const way = name === "space" ? null : { ArrowLeft: [40, 0], ArrowRight: [-40, 0],
          ArrowUp: [0, 40], ArrowDown: [0, -40] }[event.key];
        if (!by && !way) return;
        event.preventDefault();
        change(view, by ?? ((v) => v.move(...way)))();
      });
    }
  },

  // Tool changes and the beginning of cuts, over the slider.
  marks() {
    const { trace } = this, box = this.one("marks"), taken = new Set();
    const isBar = this.data.kind === "bar";
    if (!box) return;
    for (let k = 1; k < trace.count; k++) {
      if (trace.state[k] === trace.state[k - 1]) continue;
      const a = trace.states[trace.state[k - 1]], b = trace.states[trace.state[k]];
      let kind = "", said = "";
      if (isBar && b.sawing && !a.sawing) [kind, said] = ["cut", "saw cut"];
      else if (b.diameter && (b.diameter !== a.diameter || b.spindle !== a.spindle)) {
        [kind, said] = ["tool", `spindle ${b.spindle}, tool ${Numbers.plain(b.diameter)}`];
      } else if (b.process && b.process !== a.process) [kind, said] = ["cut", b.process];
      const time = trace.time[k], share = time / trace.duration;
      const place = `${kind} ${Math.round(400 * share)}`; // one is seen where several would lie
      if (!kind || taken.has(place)) continue;
      taken.add(place);
      const mark = document.createElement("i");
      mark.className = kind;
      mark.style.left = `calc(8px + (100% - 16px) * ${share.toFixed(5)})`;
      mark.title = `${said}, ${Numbers.clock(time)}`;
      mark.addEventListener("click", () => this.go(time));
      box.append(mark);
    }
  },

  // Keys anywhere in the page: blank plays, comma and dot step, Home goes to the beginning. Only
  // what is typed into keeps its keys, and a button that the keyboard came to its own two.
  key(event) {
    const at = event.target;
    if (at.closest("select, textarea, summary, input:not([type=range])")) return;
    if (at.closest("button") && (event.key === " " || event.key === "Enter")) return;
    const does = {
      " ": () => this.play(!this.playing),
      ",": () => this.go(this.trace.step(this.time, -1)),
      ".": () => this.go(this.trace.step(this.time, 1)),
      Home: () => this.go(0),
    }[event.key];
    if (!does || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    does();
  },

  turnable(canvas, view) {
    const turn = (dx, dy) => {
      this.model.yaw += dx;
      this.model.pitch = Math.min(1.5, Math.max(-1.5, this.model.pitch + dy));
      this.draw();
    };
    const change = (does) => {
      does();
      this.draw();
    };
    Gestures.on(canvas, {
      drag: (dx, dy) => turn(dx / 150, dy / 150),
      move: (dx, dy) => change(() => view.move(dx, dy)),
      zoom: (by, x, y) => change(() => view.nearer(by, x, y)),
    });
    canvas.addEventListener("keydown", (event) => {
      const way = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.1],
        ArrowDown: [0, 0.1] }[event.key];
      if (!way) return;
      event.preventDefault();
      turn(...way);
    });
  },

  // A click on what a program makes goes to the block that makes it.
  pictures() {
    this.marked = [];
    const pictures = document.querySelector(".pictures");
    if (!pictures) return;
    this.shapes = new Map();
    for (const e of document.querySelectorAll(".pictures [data-line], tr[data-line]")) {
      const line = Number(e.dataset.line);
      if (!this.shapes.has(line)) this.shapes.set(line, []);
      this.shapes.get(line).push(e);
    }
    pictures.addEventListener("click", (event) => {
      const shape = event.target.closest("[data-line]");
      if (shape) this.pick(Number(shape.dataset.line));
    });
  },

  // Goes to where a line of the program is carried out; lines that do nothing lead on.
  pick(line, way = 1) {
    const last = this.program ? this.program.lines.length : 0;
    while (line > 0 && line <= last && !this.trace.begin.has(line)) line += way;
    if (!this.trace.begin.has(line)) return;
    this.play(false);
    this.go(this.trace.begin.get(line));
  },

  play(on) {
    this.playing = on && this.trace.duration > 0;
    const button = this.one("play");
    button.textContent = this.playing ? "Pause" : "Play";
    button.setAttribute("aria-pressed", this.playing);
    if (!this.playing) return;
    if (this.time >= this.trace.duration) this.time = 0;
    let before = null;
    const frame = (now) => {
      if (!this.playing) return;
      if (before !== null) this.go(this.time + (this.speed * (now - before)) / 1000);
      before = now;
      if (this.time >= this.trace.duration) this.play(false);
      else requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  },

  go(time) {
    this.time = Math.min(this.trace.duration, Math.max(0, time));
    this.draw();
  },

  draw() {
    if (!this.trace) return;
    const t = this.time;
    this.one("time").value = t;
    this.one("time").setAttribute("aria-valuetext", Numbers.clock(t));
    this.one("clock").textContent = `${Numbers.clock(t)} / ${Numbers.clock(this.trace.duration)}`;
    for (const { name, view } of this.views) {
      if (!view.canvas.clientWidth) continue;
      if (this.data.kind !== "bar") this.model.draw(view, t);
      else if (name === "space") this.model.drawSpace(view, this.model.at(t));
      else this.model.drawFlat(view, this.model.at(t), name === "above");
    }
    this.tell(t);
    this.next(t);
    const line = this.trace.lineAt(t);
    if (this.listing) this.listing.show(line);
    this.mark(line);
  },

  // The operation that is at work, and in large letters the one that follows.
  next(t) {
    const box = this.one("next");
    if (!box || !this.operations) return;
    const { operations } = this;
    let low = 0, high = operations.length; // how many have begun
    while (low < high) {
      const middle = (low + high) >> 1;
      if (operations[middle].begin <= t + 1e-9) low = middle + 1;
      else high = middle;
    }
    const said = (op) => `${op.number}  ${op.what}${op.faces ? ` on ${op.faces}` : ""}`;
    const op = operations[low], last = operations[low - 1];
    this.write("next-what", op ? said(op) : "end of the program");
    this.write("next-when", `next, in ${Numbers.clock((op ? op.begin : this.trace.duration) - t)}`);
    this.write("last-what", last ? `begun: ${said(last)}` : "not begun");
  },

  write(id, text) {
    const e = this.one(id);
    if (e.textContent !== text) e.textContent = text;
  },

  // The axes and what is switched on, as text.
  tell(t) {
    const positions = this.trace.positions(t);
    positions.forEach((value, k) => {
      const e = this.one(`axis-${k}`);
      e.value = (Math.round(value * 1000) / 1000 + 0).toFixed(3);
      e.textContent = this.trace.axes[k].unit === "mm"
        ? Numbers.length(value, true) : Numbers.plain(value, 3, 3);
    });
    const state = this.trace.stateAt(t), words = [];
    if (state.process) words.push(`${state.process} on`);
    if (state.spindle) words.push(`spindle ${state.spindle}`);
    if (state.diameter) words.push(`tool ${Numbers.length(state.diameter)} ${Numbers.unit}`);
    if (state.turning) words.push("turning");
    if (state.coolant) words.push("coolant");
    if (state.sawing) words.push(this.data.kind === "bar" ? "sawing" : "tool on");
    const idle = this.data.kind === "guide" ? "" : "nothing on";
    this.one("state").textContent = words.join(", ") || idle;
    this.one("state").dataset.on = state.process || state.sawing || state.turning ? "yes" : "no";
  },

  // The shapes and the row of the operation whose block it is.
  mark(line) {
    if (line === this.markedLine || !this.shapes) return;
    if (this.solid) this.solid.show(line);
    this.markedLine = line;
    for (const e of this.marked) e.classList.remove("now");
    this.marked = this.shapes.get(line) ?? [];
    for (const e of this.marked) e.classList.add("now");
  },
};

Sheet.start();
