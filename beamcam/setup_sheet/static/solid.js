// What a program leaves of its bar or sheet, as a shaded solid that turns. The form of the data:
// beamcam/setup_sheet/solid_data.py. x runs along the bar, y up the web, z towards who looks at v.
//
// WebGL draws it. Without it the same triangles are drawn once into an image, which stands still.
class Solid {
  // `pieces` are unpacked (mesh.js).
  constructor(box, data, pieces, onPick) {
    this.box = box;
    this.canvas = box.querySelector("canvas");
    this.onPick = onPick;
    this.line = 0;
    this.piece = -1;
    this.yaw = -0.45;
    this.pitch = 0.45;
    this.faces = data.faces;
    this.pieces = pieces;
    this.lines = new Set(data.pieces.flatMap((piece) => piece.lines.map(([line]) => line)));
    this.letters = [...box.querySelectorAll(".face-letter")];
    const wanted = { antialias: true, preserveDrawingBuffer: true };
    this.gl = this.canvas.getContext("webgl", wanted);
    if (this.gl) this.load();
    else this.pen = this.canvas.getContext("2d");
    box.dataset.drawn = this.gl ? "webgl" : "still";
    this.fit();
    this.controls();
  }

  shown() {
    return this.pieces.filter((_, k) => this.piece < 0 || k === this.piece);
  }

  // The least and greatest corner of what is shown.
  bounds() {
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    for (const { box } of this.shown()) {
      for (let axis = 0; axis < 3; axis++) {
        low[axis] = Math.min(low[axis], box[axis]);
        high[axis] = Math.max(high[axis], box[axis] + box[3 + axis]);
      }
    }
    return [low, high];
  }

  // Rows of the matrix that turns a place to right, up, and towards the viewer.
  rows() {
    const [cy, sy, cp, sp] = [Math.cos(this.yaw), Math.sin(this.yaw), Math.cos(this.pitch),
      Math.sin(this.pitch)];
    return [[cy, 0, sy], [sp * sy, cp, -sp * cy], [-cp * sy, sp, cp * cy]];
  }

  turned(place) {
    const away = place.map((v, axis) => v - this.target[axis]);
    return this.rows().map((row) => row[0] * away[0] + row[1] * away[1] + row[2] * away[2]);
  }

  // The place of the page, in pixels of the canvas, and how near it is.
  at(place) {
    const [x, y, near] = this.turned(place);
    return [this.wide / 2 + x * this.scale, this.high / 2 - y * this.scale, near];
  }

  // Corners of all triangles of a piece in pixels, and how near they are.
  projected(piece) {
    const rows = this.rows(), found = new Float32Array(piece.at.length);
    const [tx, ty, tz] = this.target, [r, u, n] = rows;
    for (let k = 0; k < found.length; k += 3) {
      const x = piece.at[k] - tx, y = piece.at[k + 1] - ty, z = piece.at[k + 2] - tz;
      found[k] = this.wide / 2 + this.scale * (r[0] * x + r[1] * y + r[2] * z);
      found[k + 1] = this.high / 2 - this.scale * (u[0] * x + u[1] * y + u[2] * z);
      found[k + 2] = n[0] * x + n[1] * y + n[2] * z;
    }
    return found;
  }

  measure() {
    this.wide = this.canvas.clientWidth || 800;
    this.high = this.canvas.clientHeight || 400;
  }

  // All of what is shown in the middle, as large as there is room.
  fit() {
    const [low, high] = this.bounds();
    this.measure();
    this.target = low.map((v, axis) => (v + high[axis]) / 2);
    let right = 1, up = 1;
    for (let k = 0; k < 8; k++) {
      const [x, y] = this.turned([0, 1, 2].map((axis) => (k & (1 << axis) ? high : low)[axis]));
      right = Math.max(right, Math.abs(x));
      up = Math.max(up, Math.abs(y));
    }
    this.scale = Math.min((0.46 * this.wide) / right, (0.44 * this.high) / up);
    this.draw();
  }

  // Everything of a line in another colour; `look` turns its face to the viewer and goes near.
  show(line, look = false, face = "") {
    if (line === this.line && !look) return;
    const isSeen = this.lines.has(line) || this.lines.has(this.line);
    this.line = line;
    if (look) this.approach(face);
    if (look || (this.gl && isSeen)) this.draw();
  }

  approach(face) {
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    this.pieces.forEach((piece, number) => {
      for (let t = 0; t < piece.n; t++) {
        if (piece.line[t] !== this.line) continue;
        if (this.piece >= 0 && this.piece !== number) this.choose(-1);
        for (let k = 0; k < 9; k++) {
          low[k % 3] = Math.min(low[k % 3], piece.at[9 * t + k]);
          high[k % 3] = Math.max(high[k % 3], piece.at[9 * t + k]);
        }
      }
    });
    if (low[0] > high[0]) return; // it takes no steel
    const views = { v: [-0.45, 0.45], h: [Math.PI - 0.45, 0.45], o: [-0.45, 0.95],
      u: [-0.45, -0.95] };
    [this.yaw, this.pitch] = views[face] ?? views.v;
    this.target = low.map((v, axis) => (v + high[axis]) / 2);
    const [first, last] = this.bounds();
    const across = Math.max(last[1] - first[1], Math.min(last[2] - first[2], last[1] - first[1]));
    const size = Math.max(...high.map((v, axis) => v - low[axis]));
    this.scale = Math.min(this.wide, this.high) / Math.max(1.6 * across, 2.5 * size, 40);
  }

  choose(piece) {
    this.piece = piece;
    for (const button of document.querySelectorAll("button[data-piece]")) {
      button.setAttribute("aria-pressed", Number(button.dataset.piece) === piece);
    }
  }

  load() {
    const gl = this.gl, program = gl.createProgram();
    const shader = (kind, text) => {
      const made = gl.createShader(kind);
      gl.shaderSource(made, text);
      gl.compileShader(made);
      gl.attachShader(program, made);
    };
    shader(gl.VERTEX_SHADER, `attribute vec3 place; attribute vec3 normal; attribute float line;
      uniform mat3 turn; uniform vec3 target; uniform vec3 scale; uniform float now;
      varying float light; varying float lit;
      void main() {
        vec3 facing = turn * normal;
        light = 0.5 + 0.5 * max(0.0, dot(facing, normalize(vec3(-0.4, 0.55, 0.75))));
        lit = abs(line - now) < 0.5 && now > 0.5 ? 1.0 : 0.0;
        gl_Position = vec4(turn * (place - target) * scale, 1.0);
      }`);
    shader(gl.FRAGMENT_SHADER, `precision mediump float;
      uniform vec3 colour; uniform vec3 work; uniform float flat_; varying float light;
      varying float lit;
      void main() {
        gl_FragColor = vec4(mix(colour, work, lit) * mix(light, 1.0, flat_), 1.0);
      }`);
    gl.linkProgram(program);
    gl.useProgram(program);
    this.program = program;
    this.places = {};
    for (const name of ["turn", "target", "scale", "now", "colour", "work", "flat_"]) {
      this.places[name] = gl.getUniformLocation(program, name);
    }
    this.inputs = ["place", "normal", "line"].map((name) => gl.getAttribLocation(program, name));
    for (const piece of this.pieces) {
      const all = new Float32Array(21 * piece.n);
      for (let k = 0; k < 3 * piece.n; k++) {
        const t = Math.floor(k / 3);
        all.set(piece.at.subarray(3 * k, 3 * k + 3), 7 * k);
        all.set(piece.normal.subarray(3 * t, 3 * t + 3), 7 * k + 3);
        all[7 * k + 6] = piece.line[t];
      }
      piece.buffers = [all, piece.edges].map((numbers) => {
        const buffer = gl.createBuffer();
        gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
        gl.bufferData(gl.ARRAY_BUFFER, numbers, gl.STATIC_DRAW);
        return buffer;
      });
    }
  }

  static channels(colour) {
    const [r, g, b] = [1, 3, 5].map((k) => parseInt(colour.slice(k, k + 2), 16) / 255);
    return [r, g, b];
  }

  draw() {
    this.measure();
    this.count = (this.count ?? 0) + 1;
    const isPrinted = window.matchMedia("print").matches;
    const ratio = Math.max(window.devicePixelRatio || 1, isPrinted ? 2 : 1);
    const wide = Math.round(this.wide * ratio), high = Math.round(this.high * ratio);
    if (this.canvas.width !== wide) this.canvas.width = wide;
    if (this.canvas.height !== high) this.canvas.height = high;
    if (this.gl) this.drawGl();
    else this.drawStill();
    if (this.gl && isPrinted) this.copy();
    this.drawLetters();
  }

  // A printer takes no WebGL, but what is painted over it.
  copy() {
    if (!this.printed) {
      this.printed = this.canvas.cloneNode();
      this.printed.className = "printed";
      this.canvas.after(this.printed);
    }
    [this.printed.width, this.printed.height] = [this.canvas.width, this.canvas.height];
    this.printed.getContext("2d").drawImage(this.canvas, 0, 0);
  }

  drawGl() {
    const { gl, places } = this, [low, high] = this.bounds();
    const deep = 2 * Math.hypot(...high.map((v, axis) => v - low[axis])) + 1;
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    gl.clearColor(...Solid.channels(Colours.paper), 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.POLYGON_OFFSET_FILL);
    gl.polygonOffset(1, 1);
    const rows = this.rows(); // by columns, as WebGL wants them
    gl.uniformMatrix3fv(places.turn, false, [0, 1, 2].flatMap((c) => rows.map((row) => row[c])));
    gl.uniform3fv(places.target, this.target);
    gl.uniform3f(places.scale, (2 * this.scale) / this.wide, (2 * this.scale) / this.high, -1 / deep);
    gl.uniform1f(places.now, this.line);
    gl.uniform3fv(places.work, Solid.channels(Colours.work));
    for (const piece of this.shown()) {
      const [place, normal, line] = this.inputs, [all, edges] = piece.buffers;
      gl.bindBuffer(gl.ARRAY_BUFFER, all);
      for (const [input, size, from] of [[place, 3, 0], [normal, 3, 12], [line, 1, 24]]) {
        gl.enableVertexAttribArray(input);
        gl.vertexAttribPointer(input, size, gl.FLOAT, false, 28, from);
      }
      gl.uniform1f(places.flat_, 0);
      gl.uniform3fv(places.colour, Solid.channels(this.colour(piece)));
      gl.drawArrays(gl.TRIANGLES, 0, 3 * piece.n);
      gl.bindBuffer(gl.ARRAY_BUFFER, edges);
      gl.disableVertexAttribArray(normal);
      gl.disableVertexAttribArray(line);
      gl.vertexAttrib1f(line, 0);
      gl.vertexAttribPointer(place, 3, gl.FLOAT, false, 12, 0);
      gl.uniform1f(places.flat_, 1);
      gl.uniform3fv(places.colour, Solid.channels(Colours.ink));
      gl.drawArrays(gl.LINES, 0, piece.edges.length / 3);
    }
  }

  colour(piece) {
    return piece.kind === "part" ? Colours.part : Colours.steel;
  }

  // The same triangles by a depth for each pixel.
  drawStill() {
    const wide = this.canvas.width, high = this.canvas.height, ratio = wide / this.wide;
    const image = this.pen.createImageData(wide, high), depth = new Float32Array(wide * high);
    const paper = Solid.channels(Colours.paper).map((v) => 255 * v);
    for (let k = 0; k < wide * high; k++) image.data.set([...paper, 255], 4 * k);
    depth.fill(-Infinity);
    const rows = this.rows(), sun = [-0.395, 0.543, 0.741];
    for (const piece of this.shown()) {
      const places = this.projected(piece);
      for (let t = 0; t < piece.n; t++) {
        const n = rows.map((row) => row.reduce((s, v, a) => s + v * piece.normal[3 * t + a], 0));
        if (n[2] <= 0) continue;
        const light = 0.5 + 0.5 * Math.max(0, n[0] * sun[0] + n[1] * sun[1] + n[2] * sun[2]);
        const own = piece.line[t] === this.line && this.line ? Colours.work : this.colour(piece);
        const colour = Solid.channels(own).map((v) => 255 * v * light);
        const [a, b, c] = [0, 3, 6].map((k) => [places[9 * t + k] * ratio,
          places[9 * t + k + 1] * ratio, places[9 * t + k + 2]]);
        const area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        if (!area) continue;
        const x0 = Math.max(0, Math.floor(Math.min(a[0], b[0], c[0])));
        const x1 = Math.min(wide - 1, Math.ceil(Math.max(a[0], b[0], c[0])));
        const y0 = Math.max(0, Math.floor(Math.min(a[1], b[1], c[1])));
        const y1 = Math.min(high - 1, Math.ceil(Math.max(a[1], b[1], c[1])));
        for (let y = y0; y <= y1; y++) {
          for (let x = x0; x <= x1; x++) {
            const u = ((x - a[0]) * (c[1] - a[1]) - (y - a[1]) * (c[0] - a[0])) / area;
            const v = ((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])) / area;
            if (u < 0 || v < 0 || u + v > 1) continue;
            const near = a[2] + u * (b[2] - a[2]) + v * (c[2] - a[2]), k = y * wide + x;
            if (near <= depth[k]) continue;
            depth[k] = near;
            image.data[4 * k] = colour[0];
            image.data[4 * k + 1] = colour[1];
            image.data[4 * k + 2] = colour[2];
          }
        }
      }
    }
    this.pen.putImageData(image, 0, 0);
  }

  // The letters of the faces that the viewer sees, each in the middle of its face.
  drawLetters() {
    const [low, high] = this.bounds(), towards = this.rows()[2];
    const sides = { v: [2, 1], h: [2, -1], o: [1, 1], u: [1, -1] };
    for (const letter of this.letters) {
      const [axis, way] = sides[letter.dataset.face];
      // Of a long bar in the middle of what is seen of it.
      const middle = low.map((v, a) => Math.min(high[a], Math.max(v, this.target[a])));
      const place = middle.map((v, a) => (a === axis ? (way > 0 ? high : low)[a]
        : a === 0 ? v : (low[a] + high[a]) / 2));
      const [x, y] = this.at(place), is = way * towards[axis] > 0.12;
      letter.hidden = !is || x < 0 || y < 0 || x > this.wide || y > this.high;
      letter.style.left = `${x}px`;
      letter.style.top = `${y}px`;
    }
  }

  // The line that made the triangle under a place of the canvas; 0 where there is none.
  lineAt(x, y) {
    let nearest = -Infinity, found = 0;
    for (const piece of this.shown()) {
      const places = this.projected(piece);
      for (let t = 0; t < piece.n; t++) {
        const [a, b, c] = [0, 3, 6].map((k) => places.subarray(9 * t + k, 9 * t + k + 3));
        const area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        const u = ((x - a[0]) * (c[1] - a[1]) - (y - a[1]) * (c[0] - a[0])) / area;
        const v = ((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])) / area;
        if (!(u >= 0 && v >= 0 && u + v <= 1)) continue;
        const near = a[2] + u * (b[2] - a[2]) + v * (c[2] - a[2]);
        if (near > nearest) [nearest, found] = [near, piece.line[t]];
      }
    }
    return found;
  }

  turn(dx, dy) {
    this.yaw += dx;
    this.pitch = Math.min(1.57, Math.max(-1.57, this.pitch + dy));
    this.draw();
  }

  // Moves what is shown by pixels.
  move(dx, dy) {
    const [right, up] = this.rows();
    this.target = this.target.map((v, axis) => v - (dx * right[axis] - dy * up[axis]) / this.scale);
    this.draw();
  }

  zoom(by) {
    this.scale *= by;
    this.draw();
  }

  controls() {
    for (const button of document.querySelectorAll("button[data-piece]")) {
      button.addEventListener("click", () => {
        this.choose(Number(button.dataset.piece));
        this.fit();
      });
    }
    const does = { in: () => this.zoom(1.4), out: () => this.zoom(1 / 1.4), fit: () => this.fit() };
    for (const button of document.querySelectorAll("button[data-solid]")) {
      button.addEventListener("click", does[button.dataset.solid]);
    }
    if (!this.gl) return;
    Gestures.on(this.box, {
      drag: (dx, dy) => this.turn(dx / 150, dy / 150),
      move: (dx, dy) => this.move(dx, dy),
      zoom: (by) => this.zoom(by),
      click: (x, y) => {
        const line = this.lineAt(x, y);
        if (line) this.onPick(line);
      },
    });
    this.box.addEventListener("keydown", (event) => {
      const keys = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
      const way = keys[event.key];
      if (way && event.shiftKey) this.move(40 * way[0], 40 * way[1]);
      else if (way) this.turn(0.1 * way[0], 0.1 * way[1]);
      else if (event.key === "+") this.zoom(1.2);
      else if (event.key === "-") this.zoom(1 / 1.2);
      else if (event.key === "0") this.fit();
      else return;
      event.preventDefault();
    });
  }
}
