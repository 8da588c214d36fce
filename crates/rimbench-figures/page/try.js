// The part of the report that simulates: controls, two boxes, the curve of the force. What is drawn is what the module computed.
(async () => {
  "use strict";
  const $ = (id) => document.getElementById(id);
  const missing = (why) => {
    $("try-missing").hidden = false;
    $("try-missing").textContent = `Simulating in the page is not possible here: ${why}. Everything else on this page works.`;
  };
  // ---- state: the controls, in the address as well
  const STEPS = [0.2, 0.5, 1, 1.5, 2, 2.5, 3, 4, 5, 6, 7, 8, 10, 12, 15, 17, 20, 25, 30, 35, 40, 50];
  const START = { h: "5", phase: "1", mass: "200", detection: "", integrator: "", a: "rim-smooth", b: "rim-nonsmooth-gap", t: "1.735" };
  const KEYS = ["phase", "mass", "detection", "integrator", "a", "b"];
  const state = { ...START };
  const readAddress = () => {
    const address = new URLSearchParams(location.hash.slice(1));
    const known = Object.keys(START).filter((key) => address.has(key));
    if (!known.length) return false;
    // A link shows the same wherever one comes from.
    Object.assign(state, START, Object.fromEntries(known.map((key) => [key, address.get(key)])));
    const t = Number(state.t);
    state.t = Number.isFinite(t) ? String(Math.min(Math.max(t, 0), 2.5)) : START.t;
    return true;
  };
  // Browsers refuse an address that changes too often: once the hand rests is enough.
  let writing;
  const writeAddress = () => {
    clearTimeout(writing);
    writing = setTimeout(() => history.replaceState(null, "", `#${new URLSearchParams(state)}`), 200);
  };
  const nearestStep = (h) => STEPS.reduce((best, step, k) => (Math.abs(step - h) < Math.abs(STEPS[best] - h) ? k : best), 0);
  const showControls = () => {
    $("in-h").value = nearestStep(Number(state.h));
    state.h = String(STEPS[$("in-h").value]);
    for (const key of KEYS) {
      $(`in-${key}`).value = state[key];
      // What a control does not have is nonsense from an address.
      if ($(`in-${key}`).value === "" && START[key] !== "") $(`in-${key}`).value = START[key];
      state[key] = $(`in-${key}`).value;
    }
    $("out-h").textContent = `${state.h} ms`;
    $("in-h").setAttribute("aria-valuetext", `${state.h} milliseconds`);
    $("out-phase").textContent = state.phase;
    $("out-mass").textContent = `${state.mass} kg`;
  };

  // ---- the module, in a worker
  let worker, begin;
  try {
    ({ worker, begin } = await page.simulator());
  } catch (error) {
    return missing(error.message);
  }
  const kinds = new Map();
  let busy = true, wanted = false, runs = [], asked, shown;
  const request = (scheme) => {
    const lines = ["case wedge-box", `scheme ${scheme}`, `macro_step_s ${Number(state.h)}e-3`, `phase ${state.phase}`];
    if (state.mass !== START.mass) lines.push(`set.box_mass_kg ${state.mass}`);
    if (state.detection && kinds.get(scheme) === "model") lines.push(`contact_detection ${state.detection}`);
    if (state.integrator) lines.push(`mechanics_integrator ${state.integrator}`, "actuator_integrator midpoint");
    return lines;
  };
  // What both are held against: the case alone, whatever the schemes refuse.
  const reference = () => ["scheme zero-order-hold", ...request("").filter((line) => /^(case|set\.)/.test(line))].join("\n");
  const simulate = () => {
    wanted = busy;
    if (busy) return;
    busy = true;
    document.body.setAttribute("aria-busy", "true");
    const [a, b] = [request(state.a), request(state.b)].map((lines) => lines.join("\n"));
    // What comes back belongs to what was asked, wherever the controls are by then.
    asked = { schemes: [state.a, state.b], commands: [command(state.a), command(state.b)], reference: reference() };
    // The reference stays while the case does, and is far longer than the runs.
    const known = asked.reference === shown?.reference;
    worker.postMessage({ requests: [`run\n${a}`, `run\n${b}`, ...(known ? [] : [`reference\n${asked.reference}`])] });
  };
  const trajectory = ({ words, numbers }) => {
    const facts = page.facts(words);
    const names = (facts.get("columns") ?? "").split(" ");
    const width = names.length, rows = numbers.length / width;
    const index = new Map(names.map((name, k) => [name, k]));
    const value = (row, name) => numbers[row * width + index.get(name)];
    // The row at or before a time, and how far it is to the next.
    const at = (t) => {
      let low = 0, high = rows - 1;
      while (low < high) {
        const middle = (low + high + 1) >> 1;
        if (value(middle, "time_s") <= t) low = middle; else high = middle - 1;
      }
      const next = Math.min(low + 1, rows - 1), from = value(low, "time_s"), to = value(next, "time_s");
      return { row: low, next, share: to > from ? Math.min((t - from) / (to - from), 1) : 0 };
    };
    const between = (place, name) => {
      const before = value(place.row, name), after = value(place.next, name);
      return before + place.share * (after - before);
    };
    return { facts, rows, value, at, between, end: rows ? value(rows - 1, "time_s") : 0 };
  };
  worker.onerror = (event) => missing(event.message || "the worker does not start");
  worker.onmessage = ({ data }) => {
    if (data.failed) return missing(data.failed);
    if (data.ready) {
      for (const line of data.ready.split("\n").filter(Boolean)) {
        const [, name, kind] = line.split(" ");
        kinds.set(name, kind);
      }
      for (const select of [$("in-a"), $("in-b")]) select.replaceChildren(...[...kinds.keys()].map((name) => new Option(name, name)));
      readAddress();
      showControls();
      $("try-works").hidden = false;
      busy = false;
      return simulate();
    }
    busy = false;
    document.body.removeAttribute("aria-busy");
    runs = [...data.answers.map(trajectory), ...runs.slice(2)].slice(0, 3);
    shown = asked;
    show();
    if (wanted) simulate();
  };
  begin();

  // ---- drawing: the same box as in the static figure, in metres, seen by a camera that follows it
  const SVG = "http://www.w3.org/2000/svg";
  const make = (parent, name, attributes = {}, text = "") => {
    const element = parent.appendChild(document.createElementNS(SVG, name));
    for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
    element.textContent = text;
    return element;
  };
  const set = (element, attributes) => {
    for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  };
  const path = (points) => points.map(([x, y]) => `${x},${y}`).join(" ");
  const G = { width: 1, height: 0.6, tips: [[0.4, -0.4], [-0.4, -0.4]], radius: 0.2, pin: [-0.8, -0.19], ledge: 0.06, corner: -0.707, slope: 0.15, attachment: [-0.5, 0.3], ground: [-3, 0.737] };
  const BEHIND = 1.32, BELOW = 0.2, SCALE = 480 / 2.04, HEIGHT = 292, MAGNIFY = 25, LENS = 34, ARROW = 0.3 / 2000;
  const ink = { stroke: "var(--ink)", "stroke-width": 1.2, "vector-effect": "non-scaling-stroke" };
  const scene = (svg, color) => {
    svg.replaceChildren();
    const world = make(svg, "g", { class: "world" });
    make(world, "polygon", { points: path([[-9, 0], [9, 0], [9, -1], [-9, -1]]), fill: "var(--ground)" });
    make(world, "polygon", { points: path([[-9, 0], [-9, G.ledge], [G.corner, G.ledge], [G.corner + G.ledge / G.slope, 0]]), fill: "var(--ledge)", ...ink });
    make(world, "line", { x1: -9, y1: 0, x2: 9, y2: 0, ...ink });
    const rod = make(world, "polygon", { fill: "var(--metal)", ...ink });
    const chambers = [0, 1].map(() => make(world, "polygon", { ...ink }));
    const disc = make(world, "circle", { r: G.radius, fill: "var(--metal)", ...ink });
    const spoke = make(world, "line", { ...ink });
    const body = make(world, "g", { fill: color, "fill-opacity": 0.35 });
    make(body, "polygon", { points: path([[-G.width / 2, G.pin[1] + 0.14], [G.pin[0], G.pin[1] + 0.03], [G.pin[0], G.pin[1] - 0.03], [-G.width / 2, G.pin[1] - 0.05]]), ...ink });
    for (const [x, y] of G.tips) make(body, "polygon", { points: path([[x - 0.1, -G.height / 2], [x, y], [x + 0.1, -G.height / 2]]), ...ink });
    make(body, "rect", { x: -G.width / 2, y: -G.height / 2, width: G.width, height: G.height, ...ink });
    make(body, "circle", { r: 0.02, fill: "var(--paper)", "fill-opacity": 1, ...ink });
    make(body, "circle", { r: 0.012, cx: G.attachment[0], cy: G.attachment[1], fill: "var(--paper)", "fill-opacity": 1, ...ink });
    const forces = [0, 1, 2, 3].map(() => make(world, "line", { stroke: "var(--force)", "stroke-width": 3, "vector-effect": "non-scaling-stroke", "stroke-linecap": "round" }));
    // A magnifier at each wedge: a jump of 4 mm is one pixel of the drawing.
    const lenses = [0, 1].map(() => {
      const group = make(svg, "g");
      make(group, "circle", { r: LENS, fill: "var(--paper)", stroke: "var(--soft)", "stroke-width": 1.2 });
      make(group, "line", { x1: -LENS * 0.92, x2: LENS * 0.92, y1: 12, y2: 12, stroke: "var(--ink)", "stroke-width": 1.5 });
      const tip = make(group, "polygon", { fill: color, "fill-opacity": 0.5, stroke: "var(--ink)" });
      const text = make(group, "text", { y: LENS + 13, "text-anchor": "middle", "font-size": 11, fill: "var(--ink)" });
      return { group, tip, text };
    });
    make(svg, "text", { x: 474, y: 16, "text-anchor": "end", "font-size": 11, fill: "var(--soft)" }, `wedges magnified ${MAGNIFY} ×`);
    const lost = make(svg, "text", { x: 240, y: 60, "text-anchor": "middle", "font-size": 18, "font-weight": 700, fill: "var(--b)" });
    const force = make(svg, "text", { x: 8, y: 16, "font-size": 12, fill: "var(--ink)" });
    return (run, t) => {
      // A run that was refused has nothing to show.
      for (const part of [world, ...lenses.map((lens) => lens.group)]) set(part, { visibility: run.rows ? "visible" : "hidden" });
      if (!run.rows) return ([lost.textContent, force.textContent] = ["not run", ""]);
      const gone = t > run.end + 1e-9;
      const place = run.at(Math.min(t, run.end));
      const of = (name) => run.between(place, name);
      const [x, y, angle] = [of("box_x_m"), of("box_y_m"), of("box_angle_rad")];
      lost.textContent = gone ? `${run.facts.get("outcome")} at ${(run.end * 1000).toFixed(0)} ms` : "";
      if (![x, y, angle].every(Number.isFinite)) return;
      const [sin, cos] = [Math.sin(angle), Math.cos(angle)];
      const on = ([px, py]) => [x + cos * px - sin * py, y + sin * px + cos * py];
      const page = ([px, py]) => [(px - x + BEHIND) * SCALE, HEIGHT - (py + BELOW) * SCALE];
      set(world, { transform: `translate(${(BEHIND - x) * SCALE} ${HEIGHT - BELOW * SCALE}) scale(${SCALE} ${-SCALE})`, opacity: gone ? 0.35 : 1 });
      set(body, { transform: `translate(${x} ${y}) rotate(${(angle * 180) / Math.PI})` });
      const centre = on(G.pin), turn = -(centre[0] + 0.8) / G.radius;
      set(disc, { cx: centre[0], cy: centre[1] });
      set(spoke, { x1: centre[0], y1: centre[1], x2: centre[0] + G.radius * Math.cos(turn), y2: centre[1] + G.radius * Math.sin(turn) });
      const end = on(G.attachment), length = Math.hypot(end[0] - G.ground[0], end[1] - G.ground[1]);
      const [ux, uy] = [(end[0] - G.ground[0]) / length, (end[1] - G.ground[1]) / length];
      const bar = (from, to, half) => path([[from, -half], [to, -half], [to, half], [from, half]].map(([d, s]) => [G.ground[0] + d * ux - s * uy, G.ground[1] + d * uy + s * ux]));
      const piston = Math.min(Math.max(length - 1.45, 0.1), 1.9);
      set(rod, { points: bar(piston, length, 0.012) });
      ["pressure_1_pa", "pressure_2_pa"].forEach((name, k) => {
        // Of the pump's 7.6 MPa: pale is empty, deep is full.
        const share = Math.min(Math.max(of(name) / 7.6e6, 0), 1);
        set(chambers[k], { points: k ? bar(piston, 2, 0.045) : bar(0, piston, 0.045), fill: `hsl(205 60% ${88 - 50 * share}%)`, "fill-opacity": 0.75 });
      });
      const normal = of("disc_ledge_normal_rad");
      const contacts = [
        [on(G.tips[0]), [0, 1], "contact_force_right_wedge_n"],
        [on(G.tips[1]), [0, 1], "contact_force_left_wedge_n"],
        [[centre[0] - G.radius * Math.cos(normal), centre[1] - G.radius * Math.sin(normal)], [Math.cos(normal), Math.sin(normal)], "contact_force_disc_ledge_n"],
        [[centre[0], centre[1] - G.radius], [0, 1], "contact_force_disc_floor_n"],
      ];
      contacts.forEach(([[cx, cy], [nx, ny], name], k) => {
        const size = Math.min(Math.max(of(name), 0) * ARROW, 0.75) || 0;
        set(forces[k], { x1: cx, y1: cy, x2: cx + size * nx, y2: cy + size * ny, visibility: size > 0.005 ? "inherit" : "hidden" });
      });
      G.tips.forEach((tip, k) => {
        const [tx, ty] = on(tip), [left] = page([tx, ty]);
        const height = Math.min(Math.max(ty * MAGNIFY * SCALE, -16), 34);
        const top = 12 - height;
        set(lenses[k].group, { transform: `translate(${Math.min(Math.max(left, LENS + 4), 476 - LENS)} ${HEIGHT - LENS - 22})` });
        set(lenses[k].tip, { points: top < -24 ? "" : path([[0, top], [-12, Math.max(top - 18, -30)], [12, Math.max(top - 18, -30)]]) });
        lenses[k].text.textContent = `${(Math.round(ty * 1e4) / 10 + 0).toFixed(1)} mm`;
      });
      force.textContent = `F = ${(of("actuator_force_n") / 1000).toFixed(2)} kN`;
    };
  };
  const boxes = [scene($("box-a"), "var(--a)"), scene($("box-b"), "var(--b)")];

  // ---- the curve
  const PLOT = { left: 56, right: 970, top: 12, bottom: 212 };
  let span = [-1, 1];
  const across = (t) => PLOT.left + (t / 2.5) * (PLOT.right - PLOT.left);
  const up = (f) => PLOT.bottom - ((f - span[0]) / (span[1] - span[0])) * (PLOT.bottom - PLOT.top);
  const curve = $("curve");
  const drawCurve = () => {
    const of = (run) => Array.from({ length: run.rows }, (_, k) => [run.value(k, "time_s"), run.value(k, "actuator_force_n")]);
    const reference = runs[2].rows ? of(runs[2]) : [];
    const forces = reference.map(([, f]) => f);
    const [low, high] = forces.length ? [forces.reduce((a, b) => Math.min(a, b)), forces.reduce((a, b) => Math.max(a, b))] : [-1000, 1000];
    span = [low - 0.25 * (high - low), high + 0.25 * (high - low)];
    curve.replaceChildren();
    const clip = make(make(curve, "clipPath", { id: "plot" }), "rect", { x: PLOT.left, y: PLOT.top });
    set(clip, { width: PLOT.right - PLOT.left, height: PLOT.bottom - PLOT.top });
    const tick = 10 ** Math.floor(Math.log10((span[1] - span[0]) / 2));
    for (let f = Math.ceil(span[0] / tick) * tick; f <= span[1]; f += tick) {
      make(curve, "line", { x1: PLOT.left, x2: PLOT.right, y1: up(f), y2: up(f), stroke: "var(--line)" });
      make(curve, "text", { x: PLOT.left - 6, y: up(f) + 4, "text-anchor": "end", "font-size": 11, fill: "var(--soft)" }, `${(f / 1000).toFixed(1)}`);
    }
    for (let t = 0; t <= 2.5; t += 0.5) make(curve, "text", { x: across(t), y: PLOT.bottom + 16, "text-anchor": "middle", "font-size": 11, fill: "var(--soft)" }, t.toFixed(1));
    make(curve, "text", { x: (PLOT.left + PLOT.right) / 2, y: 246, "text-anchor": "middle", "font-size": 12, fill: "var(--ink)" }, "time (s)");
    make(curve, "text", { x: 14, y: 112, "text-anchor": "middle", "font-size": 12, fill: "var(--ink)", transform: "rotate(-90 14 112)" }, "actuator force (kN)");
    const line = (points, attributes) => {
      // A point per pixel is enough to see, and all of a short run.
      const every = Math.max(1, Math.floor(points.length / 2500));
      const shown = points.filter(([, f], k) => (k % every === 0 || k === points.length - 1) && Number.isFinite(f));
      const bounded = shown.map(([t, f]) => [across(t).toFixed(1), Math.min(Math.max(up(f), -1e4), 1e4).toFixed(1)]);
      make(curve, "polyline", { points: path(bounded), fill: "none", "clip-path": "url(#plot)", "stroke-linejoin": "round", ...attributes });
    };
    if (runs[0].rows) line(of(runs[0]), { stroke: "var(--a)", "stroke-width": 1.6 });
    if (runs[1].rows) line(of(runs[1]), { stroke: "var(--b)", "stroke-width": 1.6, "stroke-dasharray": "7 3" });
    line(reference, { stroke: "var(--ref)", "stroke-width": 1.6, "stroke-dasharray": "1.5 3" });
    make(curve, "line", { id: "cursor", y1: PLOT.top, y2: PLOT.bottom, stroke: "var(--force)", "stroke-width": 1.5 });
  };

  // ---- showing
  const number = (text) => (text === undefined ? "–" : Number(text).toPrecision(3));
  const caption = (element, scheme, run) => {
    const fact = (name) => run.facts.get(name);
    if (run.facts.has("error")) return (element.textContent = `${scheme}: ${fact("error")}`);
    const outcome = fact("outcome") === "completed" ? "completes" : `${fact("outcome")}: ${fact("reason") ?? ""}`;
    element.textContent = `${scheme} ${outcome}; force error ${number(fact("force_error_rms_n"))} N rms, position ${number(fact("position_error_rms_m"))} m, ${fact("exchanges") ?? 0} exchanges (run ${fact("run_id")})`;
  };
  const command = (scheme) => {
    const words = request(scheme).map((line) => {
      const [key, value] = [line.slice(0, line.indexOf(" ")), line.slice(line.indexOf(" ") + 1)];
      if (key.startsWith("set.")) return `--set ${key.slice(4)}=${value}`;
      return `--${key.replace(/_s$/, "").replaceAll("_", "-")} ${value}`;
    });
    return `cargo run --release -- simulate ${words.join(" ")}`;
  };
  const pose = () => {
    if (!runs.length) return;
    const t = Number(state.t);
    [0, 1].forEach((k) => boxes[k](runs[k], t));
    $("in-time").value = t;
    $("out-time").textContent = `${t.toFixed(3)} s`;
    const cursor = curve.querySelector("#cursor");
    if (cursor) set(cursor, { x1: across(t), x2: across(t) });
  };
  const show = () => {
    ["a", "b"].forEach((name, k) => {
      caption($(`cap-${name}`), shown.schemes[k], runs[k]);
      $(`cmd-${name}`).textContent = shown.commands[k];
    });
    drawCurve();
    pose();
    document.body.dataset.drawn = String(Number(document.body.dataset.drawn ?? 0) + 1);
  };

  // ---- controls
  $("in-h").addEventListener("input", () => {
    state.h = String(STEPS[$("in-h").value]);
    showControls();
    writeAddress();
    simulate();
  });
  for (const key of KEYS)
    $(`in-${key}`).addEventListener("input", () => {
      state[key] = $(`in-${key}`).value;
      showControls();
      writeAddress();
      simulate();
    });
  const goTo = (t) => {
    state.t = String(Math.min(Math.max(t, 0), 2.5));
    pose();
  };
  $("in-time").addEventListener("input", () => goTo(Number($("in-time").value)));
  $("in-time").addEventListener("change", writeAddress);
  const drag = (event) => {
    const box = curve.getBoundingClientRect();
    goTo((((event.clientX - box.left) / box.width) * 980 - PLOT.left) / (PLOT.right - PLOT.left) * 2.5);
  };
  curve.addEventListener("pointerdown", (event) => {
    curve.setPointerCapture(event.pointerId);
    drag(event);
  });
  curve.addEventListener("pointermove", (event) => curve.hasPointerCapture(event.pointerId) && drag(event));
  curve.addEventListener("pointerup", writeAddress);
  let playing = false, last = 0;
  const frame = (now) => {
    if (!playing) return;
    const t = Number(state.t) + Math.min((now - last) / 1000, 0.1) * Number($("speed").value);
    last = now;
    goTo(t >= 2.5 ? 0 : t);
    requestAnimationFrame(frame);
  };
  const play = (on) => {
    playing = on;
    last = performance.now();
    $("play").textContent = on ? "Pause" : "Play";
    $("play").setAttribute("aria-pressed", String(on));
    if (on) requestAnimationFrame(frame); else writeAddress();
  };
  $("play").addEventListener("click", () => play(!playing));
  document.addEventListener("keydown", (event) => {
    if (event.key !== " " || event.target.closest("button,input,select,a,summary,dialog,[tabindex]")) return;
    event.preventDefault();
    play(!playing);
  });
  for (const button of document.querySelectorAll("[data-copy]"))
    button.addEventListener("click", () => page.copy($(button.dataset.copy).textContent, button));
  addEventListener("hashchange", () => {
    if (!kinds.size || !readAddress()) return;
    showControls();
    simulate();
  });
})();
