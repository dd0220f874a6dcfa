// What the canvases of all views share: their size, their colours, and drawing in millimetres.
const Colours = {
  read() {
    const style = getComputedStyle(document.documentElement);
    for (const name of ["ink", "pale", "paper", "steel", "part", "cut", "tool", "work", "line",
      "rapid", "done"]) {
      this[name] = style.getPropertyValue(`--${name}`).trim();
    }
    this.speed = [0, 1, 2, 3, 4, 5, 6, 7].map((k) => style.getPropertyValue(`--speed-${k}`).trim());
  },
};

class View {
  constructor(canvas) {
    this.canvas = canvas;
    this.pen = canvas.getContext("2d");
    this.home();
  }

  // All of the view, as it comes.
  home() {
    this.zoom = 1;
    this.shift = [0, 0];
  }

  // A place of the whole view, in pixels, where zooming and moving puts it.
  seen([x, y]) {
    return [this.wide / 2 + (x - this.wide / 2) * this.zoom + this.shift[0],
      this.high / 2 + (y - this.high / 2) * this.zoom + this.shift[1]];
  }

  // Nearer by a factor; what lies under a place stays there.
  nearer(by, x = this.wide / 2, y = this.high / 2) {
    const zoom = Math.min(200, Math.max(0.5, this.zoom * by)), grows = zoom / this.zoom;
    this.shift = [x - this.wide / 2, y - this.high / 2]
      .map((v, k) => v - (v - this.shift[k]) * grows);
    this.zoom = zoom;
  }

  move(dx, dy) {
    this.shift = [this.shift[0] + dx, this.shift[1] + dy];
  }

  // The size of the canvas in pixels of the page; its own are as many as the screen has.
  fit() {
    const ratio = window.devicePixelRatio || 1;
    const wide = this.canvas.clientWidth, high = this.canvas.clientHeight;
    if (this.canvas.width !== Math.round(wide * ratio)) this.canvas.width = Math.round(wide * ratio);
    if (this.canvas.height !== Math.round(high * ratio)) {
      this.canvas.height = Math.round(high * ratio);
    }
    this.pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.pen.clearRect(0, 0, wide, high);
    this.wide = wide;
    this.high = high;
  }

  chain(points, stroke, { fill = null, width = 1, dash = [], closed = false } = {}) {
    const pen = this.pen;
    pen.beginPath();
    points.forEach(([x, y], k) => (k ? pen.lineTo(x, y) : pen.moveTo(x, y)));
    if (closed) pen.closePath();
    if (fill) {
      pen.fillStyle = fill;
      pen.fill();
    }
    if (stroke) {
      pen.strokeStyle = stroke;
      pen.lineWidth = width;
      pen.setLineDash(dash);
      pen.stroke();
    }
  }

  circle([x, y], radius, stroke, fill = null, width = 1) {
    const pen = this.pen;
    pen.beginPath();
    pen.arc(x, y, Math.max(radius, 0.5), 0, 2 * Math.PI);
    pen.setLineDash([]);
    if (fill) {
      pen.fillStyle = fill;
      pen.fill();
    }
    pen.strokeStyle = stroke;
    pen.lineWidth = width;
    pen.stroke();
  }

  text(words, x, y, colour, align = "left") {
    // On a ground of its own, so that lines behind it do not cross it out.
    this.pen.strokeStyle = Colours.paper;
    this.pen.lineWidth = 4;
    this.pen.lineJoin = "round";
    this.pen.setLineDash([]);
    this.pen.fillStyle = colour;
    this.pen.font = "12px system-ui, sans-serif";
    this.pen.textAlign = align;
    this.pen.strokeText(words, x, y);
    this.pen.fillText(words, x, y);
  }
}
