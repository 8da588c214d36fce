// Draws a case: shapes fixed to frames, frames moved by columns of a trace. The format is that of the crate rimbench-cases, `drawing`.
const drawing = (() => {
  "use strict";
  const ink = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
  // A canvas at the pixels of the screen, cleared, in units of CSS pixels.
  const canvas = (element) => {
    const { clientWidth: w, clientHeight: h } = element.parentElement.classList.contains("box") ? element.parentElement : element;
    const ratio = devicePixelRatio || 1;
    if (element.width !== Math.round(w * ratio) || element.height !== Math.round(h * ratio)) {
      element.width = Math.round(w * ratio);
      element.height = Math.round(h * ratio);
    }
    const g = element.getContext("2d");
    g.setTransform(ratio, 0, 0, ratio, 0, 0);
    g.clearRect(0, 0, w, h);
    g.font = "12px system-ui,sans-serif";
    g.textAlign = "left";
    g.textBaseline = "alphabetic";
    return { g, w, h };
  };
  const columnsOf = (channel) => (typeof channel === "number" ? [] : [channel.column]);
  // Every column that a drawing reads.
  const columns = (of) => {
    const frames = of.frames.flatMap(({ x, y, angle }) => [x, y, angle].flatMap(columnsOf));
    const solids = of.shapes.flatMap((shape) => shape.solids ?? []);
    frames.push(...solids.flatMap(({ pose, gap }) => [...pose.flatMap(columnsOf), ...(gap ? [gap] : [])]));
    return [...frames, ...of.shapes.filter((shape) => shape.kind === "arrow").map((shape) => shape.column), ...(of.view.follow ? [of.view.follow] : [])];
  };
  // Gives each of many bodies a frame of its own.
  const frameBodies = (of) => {
    of.shapes = of.shapes.flatMap((shape) => (shape.kind === "discs" ? shape.centres : [null]).map((centre, k) => {
      if (!centre) return shape;
      const name = `body ${k}`;
      of.frames.push({ name, x: centre[0], y: centre[1], angle: 0 });
      return { ...shape, kind: "disc", at: [0, 0, name] };
    }));
  };
  // Where every frame is, given the value of a column: [x, y, cos, sin].
  const channelOf = (value) => (c) => (typeof c === "number" ? c : c.gain * value(c.column) + c.plus);
  const poses = (of, value) => {
    const channel = channelOf(value);
    const known = new Map();
    for (const frame of of.frames) {
      const [x, y, angle] = [frame.x, frame.y, frame.angle].map(channel);
      const [px, py, cos, sin] = frame.parent ? known.get(frame.parent) : [0, 0, 1, 0];
      known.set(frame.name, [px + cos * x - sin * y, py + sin * x + cos * y, Math.cos(angle), Math.sin(angle)]);
    }
    return known;
  };
  // A spring as a zigzag of so many turns between two points.
  const zigzag = ([ax, ay], [bx, by], width) => {
    const length = Math.hypot(bx - ax, by - ay) || 1, [ux, uy] = [(bx - ax) / length, (by - ay) / length];
    const at = (share, side) => [ax + share * (bx - ax) - side * uy, ay + share * (by - ay) + side * ux];
    return [at(0, 0), at(0.12, 0), ...Array.from({ length: 10 }, (_, k) => at(0.16 + 0.068 * k, (k % 2 ? -1 : 1) * width / 2)), at(0.88, 0), at(1, 0)];
  };
  const bar = ([ax, ay], [bx, by], from, to, half) => {
    const length = Math.hypot(bx - ax, by - ay) || 1, [ux, uy] = [(bx - ax) / length, (by - ay) / length];
    return [[from, -half], [to, -half], [to, half], [from, half]].map(([d, s]) => [ax + d * ux - s * uy, ay + d * uy + s * ux]);
  };
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const minus = (a, b) => a.map((x, k) => x - b[k]);
  const middle = (points) => [0, 1, 2].map((k) => points.reduce((sum, p) => sum + p[k] / points.length, 0));
  // What is seen of bodies in space, the farthest first, and their shadows; as `faces` of the crate rimbench-figures.
  const faces = ({ camera: [across, up, towards], solids }, value) => {
    const seen = [], shadows = [];
    for (const { pose, fill, gap, corners, faces, ball, rod, width } of solids) {
      const [x, y, z, yaw, pitch, roll] = pose.map(channelOf(value));
      const [[sy, cy], [sp, cp], [sr, cr]] = [yaw, pitch, roll].map((a) => [Math.sin(a), Math.cos(a)]);
      const rows = [[cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr], [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr], [-sp, cp * sr, cp * cr]];
      const place = (p) => rows.map((row, k) => [x, y, z][k] + dot(row, p));
      // Feet are below their body, so behind it.
      const add = (near, points, light, radius) => seen.push({ near: near - (gap ? 1 : 0), points, light, radius, fill, foot: gap, off: gap && value(gap) > 1e-4 });
      if (corners) {
        const all = corners.map(place), inside = middle(all);
        for (const face of faces) {
          const points = face.map((k) => all[k]), centre = middle(points);
          const [a, b] = [minus(points[1], points[0]), minus(points[2], points[0])];
          const n = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
          const size = Math.sign(dot(n, minus(centre, inside))) * Math.hypot(...n) || 1, normal = n.map((entry) => entry / size);
          if (fill !== "ground") shadows.push(points.map(([p, q]) => [p, q, 0]));
          if (dot(normal, towards) > 0) add(dot(centre, towards), points, 0.8 * Math.max(normal[2], 0) + 0.2 * Math.max(normal[0], 0));
        }
      } else if (ball) {
        shadows.push(Array.from({ length: 24 }, (_, k) => [x + ball * Math.cos((k * Math.PI) / 12), y + ball * Math.sin((k * Math.PI) / 12), 0]));
        add(dot([x, y, z], towards), [[x, y, z]], 1, ball);
      } else {
        const [from, to] = [rod[0], place(rod[1])], span = minus(to, from), [right, high] = [dot(span, across), dot(span, up)];
        const half = (0.5 * width) / (Math.hypot(right, high) || 1);
        const beside = (p, side) => p.map((entry, k) => entry + side * half * (right * up[k] - high * across[k]));
        add(dot(to, towards), [beside(from, -1), beside(to, -1), beside(to, 1), beside(from, 1)], 1);
      }
    }
    return { seen: seen.sort((p, q) => p.near - q.near), shadows };
  };
  // One picture: `value` gives the columns of the run, enlarged; `ghost` those of the reference, thin unless the run is drawn `alone`.
  // Of a run that is `gone` the last pose stays, grey and crossed out: it does not go on.
  const draw = (element, of, { value, ghost, color, alone, gone }) => {
    const { g, w, h } = canvas(element);
    const view = of.view, shift = view.follow ? ghost(view.follow) : 0;
    const scale = Math.min(w / (view.x[1] - view.x[0]), h / (view.y[1] - view.y[0]));
    const left = w / 2 - scale * ((view.x[0] + view.x[1]) / 2 + shift), base = h / 2 + scale * (view.y[0] + view.y[1]) / 2;
    const screen = ([x, y]) => [left + scale * x, base - scale * y];
    const fills = { scheme: color, metal: ink("metal"), ground: ink("ground"), ink: ink("ink"), force: ink("force") };
    // A light colour that hides what is behind it.
    const inside = (fill) => {
      if (fill === "scheme") {
        g.fillStyle = ink("panel");
        g.fill();
        g.globalAlpha = 0.4;
      }
      g.fillStyle = fills[fill];
      g.fill();
      g.globalAlpha = 1;
    };
    const pass = (values, thin) => {
      const frames = poses(of, values);
      const place = ([x, y, frame]) => {
        const [fx, fy, cos, sin] = frame ? frames.get(frame) : [0, 0, 1, 0];
        return [fx + cos * x - sin * y, fy + sin * x + cos * y];
      };
      const path = (points, closed, fill) => {
        if (points.some(([x, y]) => !Number.isFinite(x) || !Number.isFinite(y))) return;
        g.beginPath();
        points.map(screen).forEach(([x, y]) => g.lineTo(x, y));
        if (closed) g.closePath();
        if (fill && !thin) inside(fill);
        g.lineWidth = thin ? 1 : 1.3;
        g.strokeStyle = !thin && fill === "scheme" ? color : ink("ink");
        g.stroke();
      };
      for (const shape of of.shapes) {
        const fixed = !["points", "at", "from", "to"].some((key) => [shape[key]].flat(key === "points" ? 1 : 0).some((p) => Array.isArray(p) && p[2]));
        if (thin && fixed && shape.kind !== "scene") continue;
        if (shape.kind === "scene") {
          const flat = (points) => points.map((p) => [dot(shape.camera[0], p), dot(shape.camera[1], p)]), { seen, shadows } = faces(shape, values);
          if (!seen.every(({ near }) => Number.isFinite(near))) continue;
          // One path, so that shadows that overlap are no darker.
          g.beginPath();
          for (const shadow of thin ? [] : shadows) {
            const turned = shadow.reduce((sum, [x, y], k) => sum + x * shadow[(k + 1) % shadow.length][1] - y * shadow[(k + 1) % shadow.length][0], 0);
            flat(turned > 0 ? shadow : [...shadow].reverse()).map(screen).forEach(([x, y], k) => (k ? g.lineTo(x, y) : g.moveTo(x, y)));
          }
          g.fillStyle = "rgba(0,0,0,.13)";
          g.fill();
          for (const { points, light, radius, fill, foot, off } of seen) {
            // An outline hides nothing, so feet would show through their body.
            if (thin && foot) continue;
            const [[x, y]] = flat(points).map(screen);
            if (radius) {
              g.beginPath();
              g.arc(x, y, radius * scale, 0, 7);
              if (!thin) inside(fill);
              g.lineWidth = thin ? 1 : 1.3;
              g.strokeStyle = ink("ink");
              g.stroke();
              continue;
            }
            path(flat(points), true, off ? "force" : fill);
            if (thin) continue;
            g.fillStyle = `rgba(0,0,0,${0.2 * (1 - light)})`;
            g.fill();
          }
          continue;
        }
        if (shape.kind === "polygon") path(shape.points.map(place), true, shape.fill);
        if (shape.kind === "line") path(shape.points.map(place), false, "");
        if (shape.kind === "spring") path(zigzag(place(shape.from), place(shape.to), shape.width), false, "");
        if (shape.kind === "cylinder") {
          const [from, to] = [place(shape.from), place(shape.to)], length = Math.hypot(to[0] - from[0], to[1] - from[1]);
          path(bar(from, to, Math.max(length - shape.barrel, 0) * 0.2, length, shape.width * 0.15), true, "metal");
          path(bar(from, to, 0, shape.barrel, shape.width / 2), true, "metal");
        }
        if (shape.kind === "disc") {
          const [x, y] = screen(place(shape.at)), r = shape.radius * scale;
          const [, , cos, sin] = shape.at[2] ? frames.get(shape.at[2]) : [0, 0, 1, 0];
          if (!Number.isFinite(x + y)) continue;
          g.beginPath();
          g.arc(x, y, r, 0, 7);
          if (!thin) inside(shape.fill);
          g.lineWidth = thin ? 1 : 1.3;
          g.strokeStyle = ink("ink");
          if (shape.spoke) {
            g.moveTo(x, y);
            g.lineTo(x + r * cos, y - r * sin);
          }
          g.stroke();
        }
        if (shape.kind === "arrow" && !thin) {
          const [x, y] = place(shape.at), size = Math.min(Math.max(values(shape.column) * shape.scale, 0), 0.35 * (view.y[1] - view.y[0]));
          if (!(size > 0.004 * (view.y[1] - view.y[0]))) continue;
          const tip = [x + size * shape.along[0], y + size * shape.along[1]], [sx, sy] = screen([x, y]), [tx, ty] = screen(tip);
          g.strokeStyle = g.fillStyle = ink("force");
          g.lineWidth = 2.5;
          g.beginPath();
          g.moveTo(sx, sy);
          g.lineTo(tx, ty);
          g.stroke();
          const angle = Math.atan2(ty - sy, tx - sx);
          g.beginPath();
          for (const turn of [0, 2.6, -2.6]) g.lineTo(tx + 7 * Math.cos(angle + turn), ty + 7 * Math.sin(angle + turn));
          g.fill();
        }
      }
    };
    if (value) pass(value, false);
    else for (const shape of of.shapes) if (shape.kind === "polygon" && shape.points.every((p) => !p[2])) pass(() => NaN, false);
    if (!alone) pass(ghost, true);
    if (gone) {
      const moving = of.frames.filter(({ x, y, angle }) => [x, y, angle].some((c) => typeof c !== "number"));
      const places = value && moving.length ? [poses(of, value)].flatMap((known) => moving.map(({ name }) => screen(known.get(name)))) : [];
      const [x, y] = [0, 1].map((k) => places.reduce((sum, place) => sum + place[k] / places.length, 0)), size = Math.min(0.22 * h, 40);
      const seen = places.length && x > size && x < w - size && y > size && y < h - size, [cx, cy] = seen ? [x, y] : [w / 2, h / 2];
      g.strokeStyle = ink("no");
      g.lineWidth = 6;
      g.beginPath();
      g.moveTo(cx - size, cy - size);
      g.lineTo(cx + size, cy + size);
      g.moveTo(cx + size, cy - size);
      g.lineTo(cx - size, cy + size);
      g.stroke();
    }
    return { g, w, h };
  };
  return { ink, canvas, columns, frameBodies, poses, draw };
})();
