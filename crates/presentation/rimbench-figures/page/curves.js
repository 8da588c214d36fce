// The force around the event, the force over the whole run, and below the slider what comes of every macro step.
const curves = (() => {
  "use strict";
  const { row, end, extent, digits, seconds } = verdict;
  const ticks = (low, high, count) => {
    const raw = (high - low) / count, power = 10 ** Math.floor(Math.log10(raw)), step = [1, 2, 5, 10].find((m) => m * power >= raw) * power;
    const first = Math.ceil(low / step);
    return Array.from({ length: Math.max(Math.floor(high / step) - first + 1, 0) }, (_, k) => Number(((first + k) * step).toPrecision(12)));
  };
  // The window of the event, of the runs that go on: where the force first differs by half of its largest difference. One that fails has a
  // window of its own, unless its end is in that of the event.
  const event = (of, reference, runs, macro) => {
    const force = of.force.column, T = end(reference), bound = 2 * verdict.peak(reference, force);
    const width = Math.min(Math.max(T / 10, 10 * macro), T), around = (t, share) => Math.min(Math.max(t - share * width, 0), T - width);
    const failures = runs.map((run) => run?.verdict?.when).filter(Number.isFinite), last = Math.max(...failures);
    const going = runs.filter((run) => run?.rows && !Number.isFinite(run.verdict?.when ?? NaN));
    const differences = going.flatMap((run) => [...run.columns.time_s].map((t, k) => [t, Math.min(Math.abs(run.columns[force][k] - verdict.at(reference, force, t)), bound)]));
    const most = differences.reduce((most, [, d]) => Math.max(most, d), 0);
    const first = going.length ? differences.filter(([, d]) => d >= most / 2).reduce((least, [t]) => Math.min(least, t), T) : last;
    const from = around(first, 0.3), lost = around(last, 0.7);
    const apart = failures.length && (last < from || last > from + width);
    return { event: [from, from + width], failure: apart ? [lost, lost + width] : null };
  };
  const line = (g, run, name, [X, Y], [from, to], color, width) => {
    const times = run.columns.time_s, values = run.columns[name], last = Math.min(row(run, to) + 2, run.rows), first = Math.max(row(run, from) - 1, 0);
    const every = Math.max(1, Math.floor((last - first) / 2500));
    g.beginPath();
    for (let k = first; k < last; k += every) {
      const y = Math.min(Math.max(Y(values[k]), -3000), 3000);
      if (Number.isFinite(y)) g.lineTo(X(times[k]), y);
    }
    g.strokeStyle = color;
    g.lineWidth = width;
    g.lineJoin = "round";
    g.stroke();
  };
  const clipped = (g, [left, top, right, bottom], inside) => {
    g.save();
    g.beginPath();
    g.rect(left, top, right - left, bottom - top);
    g.clip();
    inside();
    g.restore();
  };
  // The windows of what fails and of the event, in the order of time and on one scale.
  const drawEvent = (element, plot) => {
    const { g, w, h } = drawing.canvas(element), name = plot.of.force.column, small = w < 500;
    const windows = [plot.windows.event, plot.windows.failure].filter(Boolean).sort(([a], [b]) => a - b);
    const whole = extent(plot.reference.columns[name]), ends = windows.map(([from, to]) => extent(plot.reference.columns[name].subarray(row(plot.reference, from), row(plot.reference, to) + 1)));
    const [least, most] = [Math.min(...ends.map(([low]) => low)), Math.max(...ends.map(([, high]) => high))];
    const pad = Math.max(0.5 * (most - least), 0.12 * (whole[1] - whole[0] || 1)), first = small ? 40 : 54, wide = (w - first - 8 + 14) / windows.length;
    const panels = windows.map((window, k) => {
      const box = [first + k * wide, first + (k + 1) * wide - 14, 22, h - 20];
      return { box, window, timeAt: drawPanel(g, { ...plot, window, box, small: wide < 460, ends: [least - pad, most + pad], leads: k === 0, last: k === windows.length - 1 }) };
    });
    g.textAlign = "left";
    g.fillStyle = drawing.ink("ink");
    g.font = "600 12px system-ui,sans-serif";
    g.fillText(`${plot.of.force.label} (${plot.of.force.unit})`, 4, 12);
    return (x) => (panels.find(({ box }) => x <= box[1] + 7) ?? panels.at(-1)).timeAt(x);
  };
  const drawPanel = (g, { of, reference, runs, colors, window, t, macro, box: [left, right, top, bottom], small, ends: [low, high], leads, last }) => {
    const name = of.force.column, gain = of.force.gain, h = bottom + 20;
    const X = (t) => left + ((t - window[0]) / (window[1] - window[0])) * (right - left), Y = (f) => bottom - ((f - low) / (high - low)) * (bottom - top);
    const [ink, soft, grid, bad, paper] = ["ink", "soft", "line", "no", "paper"].map(drawing.ink);
    const write = (text, x, y) => {
      g.strokeStyle = paper;
      g.lineWidth = 4;
      g.strokeText(text, x, y);
      g.fillText(text, x, y);
    };
    g.font = "12px system-ui,sans-serif";
    g.textBaseline = "middle";
    g.textAlign = "right";
    for (const f of ticks(low * gain, high * gain, h < 220 ? 4 : 6)) {
      g.strokeStyle = f === 0 ? soft : grid;
      g.lineWidth = 1;
      g.beginPath();
      g.moveTo(left, Y(f / gain));
      g.lineTo(right, Y(f / gain));
      g.stroke();
      g.fillStyle = soft;
      if (leads) g.fillText(digits(f, 3), left - 5, Y(f / gain));
    }
    g.textBaseline = "alphabetic";
    g.textAlign = "center";
    for (const ms of ticks(window[0] * 1000, window[1] * 1000, small ? 4 : 8)) if (X(ms / 1000) < right - 40) g.fillText(digits(ms, 4), X(ms / 1000), h - 5);
    g.textAlign = "right";
    g.fillText("ms", right, h - 5);
    if (last) g.fillText(small ? "● communication points" : "● communication points     thin: both sides stepped together (reference)", right, 12);
    clipped(g, [left, top, right, bottom], () => {
      line(g, reference, name, [X, Y], window, ink, 1.3);
      runs.forEach((run, k) => {
        if (!run?.rows) return;
        line(g, run, name, [X, Y], window, colors[k], 2);
        if (X(macro) - X(0) < 6) return;
        g.fillStyle = colors[k];
        for (let i = row(run, window[0]); i < run.rows && run.columns.time_s[i] <= window[1]; i++) {
          g.beginPath();
          g.arc(X(run.columns.time_s[i]), Math.min(Math.max(Y(run.columns[name][i]), -99), 9999), small ? 2.6 : 3.4, 0, 7);
          g.fill();
        }
      });
    });
    runs.forEach((run, k) => {
      const when = run?.verdict?.when;
      const values = run?.rows ? run.columns[name].subarray(row(run, window[0]), Math.min(row(run, window[1]) + 1, run.rows)) : [];
      const most = values.reduce((most, f) => ((f > high || f < low) && Math.abs(f) > Math.abs(most) ? f : most), 0);
      if (when !== null && when !== undefined && when >= window[0] && when <= window[1]) {
        g.strokeStyle = colors[k];
        g.setLineDash([3, 3]);
        g.beginPath();
        g.moveTo(X(when), top);
        g.lineTo(X(when), bottom);
        g.stroke();
        g.setLineDash([]);
        g.fillStyle = bad;
        g.font = "700 12px system-ui,sans-serif";
        g.textAlign = X(when) > right - 90 ? "right" : "left";
        write("✕ fails", X(when) + (X(when) > right - 90 ? -5 : 5), most < 0 ? top + 12 + 16 * k : bottom - 8 - 16 * k);
      }
      // How far a curve goes that leaves the picture.
      if (!most || run.columns.time_s[run.rows - 1] < window[0]) return;
      g.font = "700 12px system-ui,sans-serif";
      g.fillStyle = colors[k];
      g.textAlign = "right";
      const far = Math.abs(most) > 1e6 * Math.max(Math.abs(high), Math.abs(low));
      write(`${most > 0 ? "↑" : "↓"} to ${far ? "far off" : `${digits(most * gain, 3)} ${of.force.unit}`}`, right - 4, most > 0 ? top + 12 + 16 * k : bottom - 8 - 16 * k);
    });
    if (t >= window[0] && t <= window[1]) {
      g.strokeStyle = ink;
      g.lineWidth = 1;
      g.beginPath();
      g.moveTo(X(t), top);
      g.lineTo(X(t), bottom);
      g.stroke();
    }
    return (x) => window[0] + ((x - left) / (right - left)) * (window[1] - window[0]);
  };
  const drawCourse = (element, { of, reference, runs, colors, windows, t }) => {
    const { g, w, h } = drawing.canvas(element), name = of.force.column, T = end(reference);
    const [left, right, top, bottom] = [6, w - 6, 13, h - 15], [low, high] = extent(reference.columns[name]), pad = 0.15 * (high - low || 1);
    const X = (t) => left + (t / T) * (right - left), Y = (f) => bottom - ((f - low + pad) / (high - low + 2 * pad)) * (bottom - top);
    const [ink, soft, lens] = ["ink", "soft", "lens"].map(drawing.ink);
    g.fillStyle = lens;
    g.strokeStyle = soft;
    g.lineWidth = 1;
    for (const [from, to] of [windows.event, windows.failure].filter(Boolean)) {
      g.fillRect(X(from), top, X(to) - X(from), bottom - top);
      g.strokeRect(X(from), top, X(to) - X(from), bottom - top);
    }
    clipped(g, [left, top, right, bottom], () => {
      line(g, reference, name, [X, Y], [0, T], ink, 1);
      runs.forEach((run, k) => run?.rows && line(g, run, name, [X, Y], [0, T], colors[k], 1.2));
    });
    g.fillStyle = soft;
    g.fillText("0", left, h - 2);
    g.textAlign = "right";
    g.fillText(T < 0.1 ? seconds(T) : `${digits(T, 3)} s`, right, h - 2);
    g.textAlign = "center";
    g.font = "700 14px system-ui,sans-serif";
    runs.forEach((run, k) => {
      if (!Number.isFinite(run?.verdict?.when ?? NaN)) return;
      g.fillStyle = colors[k];
      g.fillText("✕", X(run.verdict.when), 11);
    });
    g.font = "12px system-ui,sans-serif";
    g.strokeStyle = g.fillStyle = ink;
    g.lineWidth = 2;
    g.beginPath();
    g.moveTo(X(t), top - 4);
    g.lineTo(X(t), bottom + 3);
    g.stroke();
    g.textAlign = X(t) < 60 ? "left" : "center";
    g.fillText(seconds(t), Math.min(X(t), w - 70), h - 2);
    return (x) => ((x - left) / (right - left)) * T;
  };
  // Error against macro step: a dot where a scheme is usable, a ring where it completes, a cross above where it fails, a speck below where
  // it is not known. `across` says where the slider has a step.
  const drawSweep = (element, { rows, names, colors, steps, here, across }) => {
    const { g, w, h } = drawing.canvas(element), small = w < 500, [left, right, top, bottom] = [small ? 44 : 60, w - 6, 36, h - 62];
    const [ink, soft, grid, paper, bad] = ["ink", "soft", "line", "paper", "no-bg"].map(drawing.ink);
    const errors = rows.flat().map(({ error }) => error).filter((error) => error > 0), low = 0.6 * Math.min(...errors, 1e-2);
    const Y = (error) => bottom - (Math.log(Math.min(Math.max(error, low), 1) / low) / Math.log(1 / low)) * (bottom - top);
    const write = (text, x, y) => {
      g.strokeStyle = paper;
      g.lineWidth = 4;
      g.strokeText(text, x, y);
      g.fillText(text, x, y);
    };
    g.fillStyle = bad;
    g.fillRect(left, top, right - left, Y(verdict.usable) - top);
    g.fillStyle = soft;
    g.textAlign = "right";
    for (let error = 1, every = bottom - top < 20 * Math.log10(1 / low) ? 100 : 10; error >= low; error /= every) {
      g.strokeStyle = grid;
      g.lineWidth = 1;
      g.beginPath();
      g.moveTo(left, Y(error));
      g.lineTo(right, Y(error));
      g.stroke();
      g.fillText(`${digits(100 * error, 1)}\u00a0%`, left - 6, Y(error) + 4);
    }
    g.fillText(small ? "not usable" : "more than a tenth wrong", right - 6, top + 15);
    g.textAlign = "left";
    g.fillText(small ? "error" : "error of the force, of its peak", small ? 2 : 4, 12);
    // As many steps are named as there is room for, round ones first.
    g.textAlign = "center";
    const named = [], free = (x) => named.every((other) => Math.abs(other - x) > (small ? 26 : 36));
    const order = steps.map((ms, k) => [k, [1, 2, 5].includes(Number(ms.toExponential()[0])) && /^\de/.test(ms.toExponential()) ? 0 : 1]).sort(([a, p], [b, q]) => p - q || a - b);
    for (const [k] of order) {
      const x = across(k);
      if (!free(x)) continue;
      named.push(x);
      g.fillText(digits(steps[k], 3), x, bottom + 16);
    }
    g.strokeStyle = ink;
    g.lineWidth = 1.4;
    g.beginPath();
    g.moveTo(across(here), 4);
    g.lineTo(across(here), h - 44);
    g.stroke();
    const every = Math.ceil(11 / (across(1) - across(0)));
    rows.forEach((row, k) => {
      const shown = row.map(({ state, error }, i) => ({ state, x: across(i), y: state === "fails" ? 9 + 15 * k : state === "unknown" ? bottom - 3 - 5 * k : error === null ? bottom : Y(error), on: ["usable", "completes"].includes(state), seen: !((i - here) % every) }));
      g.strokeStyle = g.fillStyle = colors[k];
      g.lineWidth = 2;
      g.lineJoin = "round";
      g.beginPath();
      shown.forEach(({ on, x, y }, i) => on && (shown[i - 1]?.on ? g.lineTo(x, y) : g.moveTo(x, y)));
      g.stroke();
      for (const { state, x, y } of shown.filter(({ seen }) => seen)) {
        g.beginPath();
        if (state === "unknown") {
          g.rect(x - 1, y - 1, 2, 2);
          g.fill();
        } else if (state === "fails") {
          g.moveTo(x - 4, y - 4);
          g.lineTo(x + 4, y + 4);
          g.moveTo(x + 4, y - 4);
          g.lineTo(x - 4, y + 4);
          g.stroke();
        } else {
          g.arc(x, y, small ? 3.4 : 4.2, 0, 7);
          if (state === "completes") {
            g.save();
            g.fillStyle = paper;
            g.fill();
            g.restore();
            g.stroke();
          } else g.fill();
        }
      }
      // The name beside the curve, on its side away from the other; beside its crosses as well.
      g.font = "600 13px system-ui,sans-serif";
      const fails = shown.find(({ state }) => state === "fails"), wide = g.measureText(names[k]).width;
      g.textAlign = "right";
      if (fails && fails.x - wide > left + 110) write(small ? "fails" : `${names[k]} fails`, fails.x - 10, fails.y + 4);
      // Errors rise to the right: above a curve the name ends where it begins below it.
      const others = rows[1 - k].filter(({ error }, i) => error !== null && row[i].error !== null), own = row.filter(({ error }, i) => error !== null && rows[1 - k][i].error !== null);
      const above = own.filter(({ error }, i) => error > others[i].error || (error === others[i].error && k === 0)).length * 2 >= own.length;
      const place = above ? shown.findIndex(({ on, x }) => on && x > left + wide + 4) : shown.findIndex(({ on, x }) => on && x > left + 0.3 * (right - left) && x + wide < right);
      g.textAlign = above ? "right" : "left";
      if (place >= 0) write(names[k], shown[place].x + (above ? 4 : -4), Math.min(Math.max(shown[place].y + (above ? -9 : 19), top + 12), bottom - 3));
      g.font = "12px system-ui,sans-serif";
    });
  };
  return { event, drawEvent, drawCourse, drawSweep };
})();
