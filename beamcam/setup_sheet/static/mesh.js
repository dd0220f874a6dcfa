// Triangles of a piece as the page holds them (beamcam/setup_sheet/solid_data.py), unpacked.
const Mesh = {
  // The bytes that deflate has made short. Throws where the browser cannot read it.
  async inflated(text) {
    const bytes = Uint8Array.from(atob(text), (sign) => sign.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  },

  // Whole numbers from a place on, by their differences, all low bytes before the higher ones.
  numbers(bytes, from, count, wide) {
    const found = new Uint32Array(count), most = wide === 2 ? 0xffff : 0xffffffff;
    let last = 0;
    for (let k = 0; k < count; k++) {
      let step = 0;
      for (let plane = 0; plane < wide; plane++) {
        step += bytes[from + plane * count + k] * 256 ** plane;
      }
      found[k] = last = (last + step) % (most + 1);
    }
    return found;
  },

  // Corners of triangles one after the other, the normal and the line of each, the sharp edges.
  async unpacked({ kind, mark, box, points, triangles, wide, data, lines }) {
    const bytes = await Mesh.inflated(data), n = triangles;
    const places = [0, 1, 2].map((axis) => Mesh.numbers(bytes, 2 * points * axis, points, 2));
    const index = Mesh.numbers(bytes, 6 * points, 3 * n, wide);
    const at = new Float32Array(9 * n), normal = new Float32Array(3 * n);
    for (let k = 0; k < index.length; k++) {
      for (let axis = 0; axis < 3; axis++) {
        at[3 * k + axis] = box[axis] + (places[axis][index[k]] / 65535) * box[3 + axis];
      }
    }
    const sides = new Map(), edges = [];
    for (let t = 0; t < n; t++) {
      const p = at.subarray(9 * t, 9 * t + 9);
      const u = [p[3] - p[0], p[4] - p[1], p[5] - p[2]], v = [p[6] - p[0], p[7] - p[1], p[8] - p[2]];
      const w = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
      const long = Math.hypot(...w) || 1;
      for (let axis = 0; axis < 3; axis++) normal[3 * t + axis] = w[axis] / long;
      for (let side = 0; side < 3; side++) {
        const a = index[3 * t + side], b = index[3 * t + ((side + 1) % 3)];
        const key = a < b ? a * 4294967296 + b : b * 4294967296 + a, other = sides.get(key);
        if (other === undefined) sides.set(key, t);
        else {
          const turn = [0, 1, 2].reduce((sum, axis) => sum +
            normal[3 * t + axis] * normal[3 * other + axis], 0);
          if (turn < 0.8) {
            const c = 9 * t + 3 * side, d = 9 * t + 3 * ((side + 1) % 3);
            edges.push(at[c], at[c + 1], at[c + 2], at[d], at[d + 1], at[d + 2]);
          }
        }
      }
    }
    return { kind, mark, box, at, normal, n, line: Trace.spread(lines, n),
      edges: new Float32Array(edges) };
  },
};
