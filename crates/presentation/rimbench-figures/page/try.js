// The part of the page that simulates: a case, a macro step, two schemes side by side. What is drawn is what the module computed.
(async () => {
  "use strict";
  const $ = (id) => document.getElementById(id);
  const missing = (why) => {
    $("try-missing").hidden = false;
    $("try-missing").textContent = `Simulating in the page is not possible here: ${why}. Everything else on this page works.`;
  };
  // Colours and names are those of the figures; schemes and cases are those of the module.
  const { schemes: STYLES } = JSON.parse($("known").textContent), SCHEMES = {};
  const called = (scheme) => STYLES[scheme].name;
  let CASES = [];
  const SIDES = ["a", "b"], OPTIONS = { mass: "0", stiffness: "0", friction: "0", late: "0", phase: "1", "late-a": "", "late-b": "", "contacts-a": "", "contacts-b": "", integrator: "", step: "" };
  const { at, end, judge, milliseconds, seconds } = verdict;

  // ---- state: case, place of the slider, schemes, options, time; in the address as well
  const nearest = (of, ms) => of.steps_ms.reduce((best, step, k, all) => (Math.abs(Math.log(step / ms)) < Math.abs(Math.log(all[best] / ms)) ? k : best), 0);
  const startOf = (of) => ({ case: of.name, h: nearest(of, of.shown_ms), a: of.schemes[0], b: of.schemes[1], ...OPTIONS, t: null });
  let state;
  const current = () => CASES.find(({ name }) => name === state.case);
  const steps = () => current().steps_ms;
  const readAddress = () => {
    const address = new URLSearchParams(location.hash.slice(1));
    if (!["case", "h", ...SIDES].some((key) => address.has(key))) return false;
    state = startOf(CASES.find(({ name }) => name === address.get("case")) ?? CASES[0]);
    for (const side of SIDES) if (address.get(side) in SCHEMES) state[side] = address.get(side);
    for (const key of Object.keys(OPTIONS)) {
      const input = $(`in-${key}`), value = address.get(key) ?? OPTIONS[key];
      // Any phase, age and margin can be asked for; the hand has a few of them.
      if (/^margin:[\d.e-]+$/.test(value) && input.options && ![...input.options].some((option) => option.value === value)) input.append(new Option(value, value));
      const [some, valid] = [/^\d{1,3}$/.test(value) ? String(Number(value)) : "0", value > 0 && value <= 1 ? value : ""];
      input.value = key === "late" ? some : value;
      state[key] = (key === "late" ? some : key === "phase" && valid) || input.value;
    }
    const [h, t] = ["h", "t"].map((key) => Number(address.get(key) ?? NaN));
    if (h > 0) state.h = nearest(current(), h);
    if (Number.isFinite(t)) state.t = t;
    return true;
  };
  // Browsers refuse an address that changes too often: once the hand rests is enough.
  let writing;
  const writeAddress = () => {
    clearTimeout(writing);
    writing = setTimeout(() => {
      const entries = Object.entries({ ...state, h: steps()[state.h], t: state.t === null ? undefined : Number(state.t.toPrecision(5)) }).filter(([key, value]) => value !== undefined && value !== OPTIONS[key]);
      history.replaceState(null, "", `#${new URLSearchParams(entries)}`);
    }, 250);
  };

  // ---- the machine: what is set of it goes from a third to three times the value that it has
  const FACTORS = [1 / 3, 1 / 2, 0.7, 1, 1.4, 2, 3];
  const round = (value) => Number(value.toPrecision(2));
  // A slider of the machine: its words, its parameter, the value that is set (none where it stands), and how that is read.
  const knob = (kind) => {
    const of = current()?.knobs[kind];
    if (!of) return null;
    const [name, start, about] = of, factor = FACTORS[3 + Number(state[kind])], oil = name.startsWith("compressibility");
    const value = factor === 1 ? start : round(oil ? start / factor : start * factor), shown = oil ? round(1e-9 / value) : value;
    const words = oil ? "stiffness of the oil" : about.split(/[,;]/)[0].replace(/^(?:viscous )?(\w+) \S{1,3}(?= of | between |$)/, "$1");
    const unit = oil ? "GPa" : { kg: "kg", n_m: "N/m", n_s_m: "N·s/m" }[name.match(/kg$|n_s_m$|n_m$/)[0]];
    const kilo = unit.startsWith("N") && shown >= 1000;
    return { words: words[0].toUpperCase() + words.slice(1), set: factor === 1 ? "" : `set.${name} ${value}`, shown: `${verdict.digits(kilo ? shown / 1000 : shown)}\u00a0${kilo ? "k" : ""}${unit}` };
  };
  const MACHINE = ["mass", "stiffness", "friction"];
  const machine = () => [`case ${state.case}`, ...MACHINE.map((kind) => knob(kind)?.set).filter(Boolean)].join("\n");

  // ---- what is known, and two workers that find out more
  const runs = new Map(), references = new Map(), workers = [];
  const lines = (side, h = state.h) => {
    const scheme = state[side];
    const own = [machine(), `scheme ${scheme}`, `macro_step_s ${steps()[h]}e-3`, `phase ${state.phase}`];
    const contacts = state[`contacts-${side}`];
    if (contacts && SCHEMES[scheme].model) own.push(`contact_detection ${contacts}`);
    if (state.late > 0) own.push(`delivery_up delay:${state.late}`, ...(state[`late-${side}`] ? [`late_samples ${state[`late-${side}`]}`] : []));
    // At a shorter macro step the mechanics takes one step; the profile of several is that of a model.
    if (state.step && state.step < steps()[h] / 1000) own.push(`mechanics_step_s ${state.step}`, ...(SCHEMES[scheme].model ? ["force_return profile"] : []));
    if (state.integrator) own.push(`mechanics_integrator ${state.integrator}`, "actuator_integrator midpoint");
    return own.join("\n");
  };
  const known = (side, h = state.h) => runs.get(lines(side, h));
  const referenceOf = (of, id = `case ${of.name}`) => ({ of, id, request: `reference\n${id}\nscheme zero-order-hold`, into: references });
  const truth = () => references.get(machine());
  // What the story tells of the lock, beside what is drawn; cases without these columns have nothing of it.
  const LOCK = { mass: "effective_mass_kg", gap: "gap_left_wedge_m", contact: "contact_force_left_wedge_n" };
  const wanted = (of) => [...new Set(["time_s", of.force.column, ...drawing.columns(of.drawing), ...Object.values(LOCK)])];
  let moved = -1e9;
  const asked = (id) => workers.some(({ job }) => job?.id === id);
  const next = (slot) => {
    const side = SIDES[slot % 2], of = current();
    if (slot === 0 && !truth()) return referenceOf(of, machine());
    const ask = (h) => ({ of, id: lines(side, h), request: `run\n${lines(side, h)}`, into: runs });
    if (!known(side) && !asked(lines(side))) return ask(state.h);
    // What the gallery shows, one worker from its beginning and one from its end.
    const pictured = !$("cases").hidden && (slot ? [...CASES].reverse() : CASES).find(({ name }) => !references.has(`case ${name}`) && !asked(`case ${name}`));
    if (pictured) return referenceOf(pictured);
    // Nothing is waited for: the neighbours on the slider; short macro steps, which take long, only while the hand rests.
    const resting = performance.now() - moved > 400;
    const places = steps().map((_, h) => h).sort((p, q) => Math.abs(p - state.h) - Math.abs(q - state.h));
    const open = places.find((h) => !known(side, h) && !asked(lines(side, h)) && (resting || steps()[h] >= steps()[7]));
    return open === undefined ? null : ask(open);
  };
  let sign;
  const feed = () => {
    for (const worker of workers) {
      if (worker.job) continue;
      const job = next(worker.slot);
      if (!job) continue;
      worker.job = job;
      worker.postMessage({ id: job.id, requests: [job.request], wanted: wanted(job.of) });
    }
    const waiting = !truth() || SIDES.some((side) => !known(side));
    if (!waiting) {
      clearTimeout(sign);
      sign = undefined;
      document.body.removeAttribute("aria-busy");
    } else sign ??= setTimeout(() => document.body.setAttribute("aria-busy", "true"), 150);
  };
  const arrive = (worker, { answers: [answer] }) => {
    const { id, into } = worker.job;
    worker.job = null;
    into.set(id, { facts: page.facts(answer.words), columns: answer.columns, rows: answer.rows });
    if (id === machine() || SIDES.some((side) => id === lines(side))) show(); else if (into === runs) map();
    feed();
  };

  // ---- what is shown: a pair of runs, their reference, the window of the event, how much differences are enlarged
  let shown = null;
  const dark = () => matchMedia("(prefers-color-scheme: dark)").matches;
  const color = (scheme) => STYLES[scheme].colors[dark() ? 1 : 0], colors = () => SIDES.map((side) => color(state[side]));
  // The largest factor at which the worse of both stays in the picture as long as it runs.
  const enlargement = (of, reference, pair) => {
    const width = of.drawing.view.x[1] - of.drawing.view.x[0];
    // What is fixed to a frame shows its turns as well.
    const ends = of.drawing.shapes.flatMap(({ points = [], at, from, to }) => [...points, at, from, to].filter((point) => point?.[2]));
    const place = (frames, [x, y, name]) => {
      const [px, py, cos, sin] = frames.get(name);
      return [px + cos * x - sin * y, py + sin * x + cos * y];
    };
    let worst = 0;
    for (const run of pair) {
      for (let s = 0; run?.rows && s <= 120; s++) {
        const t = (s / 120) * end(run);
        const [ours, theirs] = [run, reference].map((trace) => drawing.poses(of.drawing, (name) => at(trace, name, t)));
        for (const end of [...ours.keys()].map((name) => [0, 0, name]).concat(ends)) {
          const [p, q] = [place(ours, end), place(theirs, end)];
          worst = Math.max(worst, Math.hypot(p[0] - q[0], p[1] - q[1]));
        }
      }
    }
    // A run that is far off is drawn nearer to what it is.
    const most = pair.some((run) => run.verdict.state !== "usable") ? 10 : 20;
    return [20, 10, 5, 2].find((factor) => factor <= most && factor * worst <= 0.06 * width) ?? 1;
  };
  const pose = () => {
    if (!shown) return;
    const { of, reference, pair, windows, factor } = shown, t = Math.min(state.t, end(reference));
    const inks = colors();
    SIDES.forEach((side, k) => {
      const run = pair[k], ghost = (name) => at(reference, name, t), gone = run.verdict.failed && t > end(run);
      // Of the columns that place frames the difference is enlarged; forces are as they are.
      const value = (name) => {
        const [own, other] = [at(run, name, Math.min(t, end(run))), ghost(name)];
        return gone || /_n$/.test(name) ? own : other + factor * (own - other);
      };
      const { g, w, h } = drawing.draw($(`scene-${side}`), of.drawing, { ghost, color: gone ? drawing.ink("soft") : inks[k], value: run?.rows ? value : null, gone });
      g.fillStyle = drawing.ink("soft");
      g.fillText(w > 300 ? "thin outline: reference" : gone ? "outline: truth" : "outline: reference", 8, h - 8);
      g.textAlign = "right";
      if (gone) g.fillText(`${w < 300 ? "" : "it ends "}at ${seconds(end(run))}`, w - 8, h - 8);
      else if (factor > 1) g.fillText(`${w < 300 ? "" : "differences "}× ${factor}`, w - 8, h - 8);
    });
    const plot = { of, reference, runs: pair, colors: inks, windows, t, macro: of.steps_ms[shown.h] / 1000 };
    shown.timeInEvent = curves.drawEvent($("event"), plot);
    shown.timeInCourse = curves.drawCourse($("course"), plot);
    $("strip").setAttribute("aria-valuemax", end(reference).toFixed(3));
    $("strip").setAttribute("aria-valuenow", t.toFixed(4));
    $("strip").setAttribute("aria-valuetext", seconds(t));
    document.body.dataset.pictured ??= String(Math.round(performance.now()));
    document.body.dataset.drawn = String(Number(document.body.dataset.drawn ?? 0) + 1);
  };
  const map = () => {
    const of = current(), reference = truth();
    const place = (side, h) => {
      const run = known(side, h);
      return run && reference ? judge(run, of) : { state: "unknown", error: null };
    };
    const rows = SIDES.map((side) => steps().map((_, h) => place(side, h)));
    const names = SIDES.map((side, k) => (state.a === state.b ? `${called(state[side])}, ${["left", "right"][k]}` : called(state[side])));
    const inks = colors(), slider = $("in-h"), thumb = 12, wide = slider.clientWidth - 2 * thumb;
    const across = (h) => slider.offsetLeft + thumb + (h / (steps().length - 1)) * wide;
    curves.drawSweep($("map"), { rows, names, colors: inks, steps: steps(), here: state.h, across });
    $("out-h").style.left = `${Math.min(Math.max(across(state.h), 150), slider.offsetLeft + slider.clientWidth - 30)}px`;
    const states = rows.map((row) => row.map(({ state }) => state));
    const said = states.map((row, k) => `${names[k][0].toUpperCase()}${names[k].slice(1)}: ${verdict.answer(row, steps())}`);
    SIDES.forEach((side, k) => {
      $(`answer-${side}`).textContent = said[k];
      $(`answer-${side}`).style.setProperty("--own", inks[k]);
    });
    const knobs = MACHINE.map(knob).filter((one) => one?.set);
    $("answer-machine").textContent = knobs.length ? `With ${knobs.map(({ words, shown }) => `${words[0].toLowerCase()}${words.slice(1)} ${shown}`).join(", ")}: ${said.join(" ")}` : said.join(" ");
    const fails = states.map((row, k) => `${names[k]}: ${row.filter((state) => state === "fails").length} of ${row.length} macro steps fail`);
    $("map").setAttribute("aria-label", `Error of the force against macro step. ${said.join(" ")} ${fails.join("; ")}`);
    $("map").dataset.unknown = String(states.flat().filter((state) => state === "unknown").length);
  };
  const command = (side) => {
    const options = lines(side).split("\n").map((line) => line.split(" ")).filter(([key, value]) => !(key === "phase" && value === "1"));
    return `cargo run --release -- simulate ${options.map(([key, value]) => key.startsWith("set.") ? `--set ${key.slice(4)}=${value}` : `--${key.replace(/_s$/, "").replaceAll("_", "-")} ${value}`).join(" ")}`;
  };
  const controls = () => {
    const of = current();
    $("in-case").value = state.case;
    $("in-h").value = state.h;
    $("out-h").textContent = milliseconds(steps()[state.h]);
    $("in-h").setAttribute("aria-valuetext", $("out-h").textContent);
    $("out-phase").textContent = state.phase;
    $("out-late").textContent = state.late > 0 ? `${state.late}\u00a0step${state.late > 1 ? "s" : ""}` : "in\u00a0time";
    $("in-late").setAttribute("aria-valuetext", $("out-late").textContent);
    for (const key of Object.keys(OPTIONS)) $(`in-${key}`).value = state[key];
    for (const kind of MACHINE) {
      const of = knob(kind), [label, out] = $(`knob-${kind}`).children;
      $(`knob-${kind}`).hidden = !of;
      if (!of) continue;
      [label.textContent, out.textContent] = [of.words, of.shown];
      $(`in-${kind}`).setAttribute("aria-valuetext", of.shown);
    }
    SIDES.forEach((side, k) => {
      for (const option of $(`in-${side}`).options) option.disabled = of.refused.includes(option.value);
      $(`in-${side}`).value = $(`in-${side}`).title = state[side];
      $(`in-contacts-${side}`).disabled = !SCHEMES[state[side]].model;
      $(`in-late-${side}`).disabled = !(state.late > 0);
      $(`side-${side}`).style.setProperty("--own", colors()[k]);
      $(`cmd-${side}`).textContent = command(side);
    });
  };
  // Six states of the address, each with the one control that leads to it; what is told of a run is taken from it.
  const told = (k) => [shown.pair[k].verdict.words, shown.pair[k].verdict.numbers].filter(Boolean).join(", ");
  const locked = () => {
    const [{ columns: run }, { columns: truth }] = [shown.pair[0], shown.reference];
    const lock = run.time_s[run[LOCK.mass].indexOf(Infinity)], touch = truth.time_s[truth[LOCK.contact].findIndex((force) => force > 0)];
    return lock < touch ? `locks ${seconds(touch - lock)} before the touch-down, the wedge ${verdict.digits(1000 * at(shown.pair[0], LOCK.gap, lock), 3)}\u00a0mm above the floor` : "fails";
  };
  const STORY = [
    ["Hold", "h=1&a=zero-order-hold&b=first-order-hold", "play", () => `Each side holds the other's last value, or extrapolates it. At a macro step of 1 ms: ${told(0)}. Press Play.`],
    ["Longer step", "h=3&a=zero-order-hold&b=first-order-hold", "in-h", () => `The macro step is 3 ms now. On the left: ${told(0)}.`],
    ["Smooth model", "h=5&a=rim-smooth&b=first-order-hold&contacts-a=margin:1e-3", "in-a", () => `At 5 ms, as in the paper, the cylinder on the left has a model of the box that counts contacts within 1 mm as closed. It ${locked()}: ${told(0)}.`],
    ["Non-smooth model", "h=5&a=rim-smooth&b=rim-nonsmooth&contacts-a=margin:1e-3", "in-b", () => `The model on the right lets contacts open within the step: ${told(1)}.`],
    ["Late", "h=5&a=rim-nonsmooth-gap&b=rim-nonsmooth-gap&late=2&late-a=raw", "in-late", () => `Samples are two macro steps old. Taken for the present (left): ${told(0)}. Run forward to the present by the model (right): ${told(1)}.`],
    ["Own step", "h=10&a=rim-nonsmooth&b=rim-nonsmooth-gap&step=1e-3", "in-h", () => `At 10 ms the mechanics takes steps of 1 ms, as engines do. A model that lets contacts open (left): ${told(0)}. One that lets them close as well (right): ${told(1)}.`],
  ];
  const story = () => {
    const options = Object.keys(OPTIONS).filter((key) => state[key] !== OPTIONS[key]).map((key) => `&${key}=${state[key]}`);
    const here = `h=${steps()[state.h]}&a=${state.a}&b=${state.b}${options.join("")}`;
    const now = state.case === "wedge-box" ? STORY.findIndex(([, address]) => address === here) : -1;
    [...$("story-steps").querySelectorAll("a")].forEach((link, k) => (k === now ? link.setAttribute("aria-current", "step") : link.removeAttribute("aria-current")));
    for (const [, , control] of STORY) $(control).classList.toggle("asked", control === STORY[now]?.[2]);
    const raw = SIDES.flatMap((side, k) => (state.late > 0 && state[`late-${side}`] ? [` On the ${["left", "right"][k]} late samples are taken for the present.`] : []));
    $("story-said").textContent = now < 0 ? current().about + raw.join("") : STORY[now][3]();
  };
  const show = () => {
    const of = current(), reference = truth(), pair = SIDES.map((side) => known(side));
    controls();
    map();
    // Both pictures change at once; until then the last ones stay, unless they are of another case.
    if (!reference || pair.includes(undefined)) {
      if (shown?.of !== of || reference?.facts.has("error")) {
        shown = null;
        for (const id of ["scene-a", "scene-b", "event", "course"]) drawing.canvas($(id));
      }
      for (const side of SIDES) if (!shown) [$(`verdict-${side}`).textContent, $(`numbers-${side}`).textContent] = [reference?.facts.get("error") ?? "computing …", ""];
      return;
    }
    if (!reference.rows) return;
    const judged = pair.map((run) => judge(run, of)), windows = curves.event(of, reference, pair, steps()[state.h] / 1000);
    // A window stays while its event stays in the middle: it must not jump under the hand.
    for (const key of ["event", "failure"]) {
      const [now, last] = [windows[key], shown?.of === of ? shown.windows[key] : null];
      if (now && last && now[0] > last[0] - 0.2 * (last[1] - last[0]) && now[1] < last[1] + 0.2 * (last[1] - last[0])) windows[key] = last;
    }
    shown = { of, reference, pair, h: state.h, windows };
    shown.factor = enlargement(of, reference, pair);
    if (state.t === null) {
      const [from, to] = windows.event, still = opened || matchMedia("(prefers-reduced-motion: reduce)").matches;
      state.t = still ? from + 0.55 * (to - from) : from;
      if (!still) requestAnimationFrame(() => play(true, to));
    }
    opened = true;
    state.t = Math.min(Math.max(state.t, 0), end(reference));
    SIDES.forEach((side, k) => {
      const out = $(`verdict-${side}`), { sign, words, numbers, why } = judged[k];
      [out.textContent, out.title, out.className] = [`${sign} ${words}`, why, judged[k].state];
      $(`numbers-${side}`).textContent = numbers;
      out.dataset.run = pair[k].facts.get("run_id") ?? "";
      $(`scene-${side}`).setAttribute("aria-label", `${of.title}, ${called(state[side])}: ${words}`);
    });
    const said = SIDES.map((side, k) => `${called(state[side])}: ${[judged[k].words, judged[k].numbers].filter(Boolean).join(", ")}`);
    $("event").setAttribute("aria-label", `${of.force.label} around the event. ${said.join("; ")}`);
    story();
    pose();
  };

  // ---- the hand
  let queued = false;
  const change = () => {
    moved = performance.now();
    writeAddress();
    feed();
    if (queued) return;
    queued = true;
    requestAnimationFrame(() => {
      queued = false;
      show();
    });
  };
  const choose = (name) => {
    play(false);
    state = startOf(CASES.find((of) => of.name === name));
    change();
  };
  // The gallery: the reference of every case, moving while it is open.
  const gallery = (now) => {
    if ($("cases").hidden) return;
    const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
    [...$("cases").children].forEach((button, k) => {
      const of = CASES[k], reference = references.get(`case ${of.name}`);
      if (of.name === state.case) button.setAttribute("aria-current", "true"); else button.removeAttribute("aria-current");
      if (!reference?.rows) return;
      const t = still ? 0 : ((now / 6000) % 1) * end(reference), value = (name) => at(reference, name, t);
      drawing.draw(button.firstChild, of.drawing, { value, ghost: value, color: color(of.schemes[1]), alone: true });
    });
    setTimeout(() => requestAnimationFrame(gallery), 40);
  };
  const hang = (open) => {
    $("cases").hidden = !open;
    $("gallery").setAttribute("aria-expanded", String(open));
    if (!open) return;
    feed();
    if (!$("cases").children.length)
      $("cases").append(
        ...CASES.map(({ name, title, about }) => {
          const button = page.make("button", { type: "button", title: about }, page.make("canvas", { "aria-hidden": "true" }), title);
          button.addEventListener("click", () => {
            hang(false);
            $("in-case").focus();
            choose(name);
          });
          return button;
        }),
      );
    gallery(performance.now());
  };
  const goTo = (t) => {
    if (!shown) return;
    state.t = Math.min(Math.max(t, 0), end(shown.reference));
    pose();
  };
  const scrub = (element, timeAt) => {
    const move = (event) => {
      if (!shown) return;
      play(false);
      goTo(timeAt()(event.clientX - element.getBoundingClientRect().left));
    };
    element.addEventListener("pointerdown", (event) => {
      element.setPointerCapture(event.pointerId);
      move(event);
    });
    element.addEventListener("pointermove", (event) => element.hasPointerCapture(event.pointerId) && move(event));
    element.addEventListener("pointerup", writeAddress);
  };
  // The page opens at the event, in motion, up to the end of its window, once.
  let playing = false, last = 0, opened = false, until = Infinity;
  const frame = (now) => {
    if (!playing || !shown) return;
    const { windows: { event: [from, to] }, reference } = shown, T = end(reference), passed = Math.min((now - last) / 1000, 0.1);
    last = now;
    // Slow motion around the event: four seconds for it, three for all the rest.
    const inside = state.t >= from && state.t < to;
    const t = state.t + passed * (inside ? (to - from) / 4 : Math.max(T - (to - from), 1e-6) / 3);
    if (t >= until) return play(false);
    goTo(t >= T ? 0 : t);
    requestAnimationFrame(frame);
  };
  const play = (on, to = Infinity) => {
    if (on === playing || (on && !shown)) return;
    // What the page does by itself is not written into the address.
    const asked = until === Infinity;
    [playing, until] = [on, to];
    last = performance.now();
    $("play").textContent = on ? "Pause" : "Play";
    $("play").setAttribute("aria-pressed", String(on));
    if (on) requestAnimationFrame(frame); else if (asked) writeAddress();
  };
  const listen = () => {
    $("gallery").addEventListener("click", () => hang($("cases").hidden));
    for (const id of ["gallery", "cases"])
      $(id).addEventListener("keydown", (event) => {
        if (event.key !== "Escape") return;
        hang(false);
        $("gallery").focus();
      });
    $("in-case").addEventListener("input", () => choose($("in-case").value));
    $("in-h").addEventListener("input", () => {
      state.h = Number($("in-h").value);
      change();
    });
    for (const key of [...SIDES, ...Object.keys(OPTIONS)])
      $(`in-${key}`).addEventListener("input", () => {
        state[key] = $(`in-${key}`).value;
        change();
      });
    // The curve is the slider as well.
    const pull = (event) => {
      const slider = $("in-h"), share = (event.clientX - slider.getBoundingClientRect().left - 12) / (slider.clientWidth - 24), h = Math.round(Math.min(Math.max(share, 0), 1) * (steps().length - 1));
      if (h === state.h) return;
      state.h = h;
      change();
    };
    $("map").addEventListener("pointerdown", (event) => {
      $("map").setPointerCapture(event.pointerId);
      pull(event);
    });
    $("map").addEventListener("pointermove", (event) => $("map").hasPointerCapture(event.pointerId) && pull(event));
    scrub($("strip"), () => shown.timeInCourse);
    scrub($("event"), () => shown.timeInEvent);
    $("play").addEventListener("click", () => play(!playing));
    $("strip").addEventListener("keydown", (event) => {
      if (!shown) return;
      const step = (shown.windows.event[1] - shown.windows.event[0]) / 60, to = { ArrowLeft: state.t - step, ArrowRight: state.t + step, Home: 0, End: Infinity }[event.key];
      if (to === undefined) return;
      event.preventDefault();
      goTo(to);
      writeAddress();
    });
    // Space plays from wherever the hand is in this part of the page, but where it has a meaning of its own.
    document.addEventListener("keydown", (event) => {
      const own = event.target.closest("select,summary,dialog,a,#cases,#gallery,[data-copy],input[type=search]");
      if (event.key !== " " || own || (event.target.closest("button,[tabindex]") && !event.target.closest("#try"))) return;
      event.preventDefault();
      if (!event.repeat) play(!playing);
    });
    $("play").addEventListener("keyup", (event) => event.key === " " && event.preventDefault());
    for (const button of document.querySelectorAll("[data-copy]")) button.addEventListener("click", () => page.copy($(button.dataset.copy).textContent, button));
    // A canvas has as many pixels as it is shown with, whatever moves it.
    const sized = new ResizeObserver(() => {
      pose();
      map();
    });
    for (const box of document.querySelectorAll("#try-works .box")) sized.observe(box);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
      controls();
      pose();
      map();
    });
    addEventListener("hashchange", () => {
      if (!readAddress()) return;
      play(false);
      $("try").scrollIntoView();
      change();
    });
  };

  // ---- begin
  const furnish = ({ ready, cases }) => {
    for (const line of ready.split("\n").filter(Boolean)) {
      const [, name, kind] = line.split(" ");
      SCHEMES[name] = { model: kind === "model" };
    }
    CASES = JSON.parse(cases);
    CASES.forEach((of) => drawing.frameBodies(of.drawing));
    state = startOf(CASES[0]);
    $("in-h").max = steps().length - 1;
    for (const key of ["contacts", "late"]) $(`in-${key}-b`).append(...[...$(`in-${key}-a`).options].map((option) => option.cloneNode(true)));
    const lead = (name, address) => page.make("li", {}, page.make("a", { href: `#case=wedge-box&${address}` }, name));
    $("story-steps").append(...STORY.map(([name, address]) => lead(name, address)));
    $("in-case").append(...CASES.map(({ title, name }) => new Option(title, name)));
    for (const side of SIDES) $(`in-${side}`).append(
        ...Object.keys(SCHEMES).map((name) => {
          const option = new Option(called(name), name);
          option.title = name;
          return option;
        }),
      );
    // An address that names what is not there is put right.
    if (readAddress()) writeAddress();
    $("try-works").hidden = false;
    for (const link of document.querySelectorAll("a.live")) link.hidden = false;
    listen();
    show();
  };
  // Two for the pair; where the machine has more cores, two more for the rest of the slider.
  const slots = [...SIDES, ...((navigator.hardwareConcurrency ?? 2) > 3 ? SIDES : [])];
  let simulators;
  try {
    simulators = await Promise.all(slots.map(() => page.simulator()));
  } catch (error) {
    return missing(error.message);
  }
  simulators.forEach(({ worker, begin }, slot) => {
    worker.slot = slot;
    worker.onerror = (event) => missing(event.message || "the worker does not start");
    worker.onmessage = ({ data }) => {
      if (data.failed) return missing(data.failed);
      if (!data.ready) return arrive(worker, data);
      if (!CASES.length) furnish(data);
      workers.push(worker);
      feed();
    };
    begin();
  });
  setInterval(() => CASES.length && feed(), 300);
})();
