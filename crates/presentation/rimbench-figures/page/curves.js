// The force around the event, the force over the whole run, and below the slider what comes of every macro step.
const curves = (() => {
  "use strict";
  const { row, end, extent, digits, seconds } = verdict;
  const ticks = (low, high, count) => {
    const raw = (high - low) / count, power = 10 ** Math.floor(Math.log10(raw)), step = [1, 2, 5, 10].find((m) => m * power >= raw) * power;
    const first = Math.ceil(low / step);
    return Array.from({ length: Math.max(Math.floor(high / step) - first + 1, 0) }, (_, k) => Number(((first + k) * step).toPrecision(12)));
  };
  // The window of the event: at the last failure, else where the force first differs by half of its largest difference.
  const event = (of, reference, runs, macro) => {
    const force = of.force.column, T = end(reference), bound = 2 * verdict.peak(reference, force);
    const failures = runs.map((run) => run?.verdict?.when).filter(Number.isFinite);
    let middle = Math.max(...failures);
    if (!failures.length) {
      const differences = runs.flatMap((run) => (run?.rows ? [...run.columns.time_s].map((t, k) => [t, Math.min(Math.abs(run.columns[force][k] - verdict.at(reference, force, t)), bound)]) : []));
      const most = differences.reduce((most, [, d]) => Math.max(most, d), 0);
      middle = differences.filter(([, d]) => d >= most / 2).reduce((least, [t]) => Math.min(least, t), T);
    }
    const width = Math.min(Math.max(T / 10, 10 * macro), T), from = Math.min(Math.max(middle - 0.3 * width, 0), T - width);
    return [from, from + width];
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
  const drawEvent = (element, { of, reference, runs, colors, window, t, macro }) => {
    const { g, w, h } = drawing.canvas(element), name = of.force.column, gain = of.force.gain, small = w < 500;
    const [left, right, top, bottom] = [small ? 40 : 54, w - 8, 22, h - 20];
    const [whole, seen] = [extent(reference.columns[name]), extent(reference.columns[name].subarray(row(reference, window[0]), row(reference, window[1]) + 1))];
    const pad = Math.max(0.5 * (seen[1] - seen[0]), 0.12 * (whole[1] - whole[0] || 1)), [low, high] = [seen[0] - pad, seen[1] + pad];
    const X = (t) => left + ((t - window[0]) / (window[1] - window[0])) * (right - left), Y = (f) => bottom - ((f - low) / (high - low)) * (bottom - top);
    const [ink, soft, grid, bad] = ["ink", "soft", "line", "no"].map(drawing.ink);
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
      g.fillText(digits(f, 3), left - 5, Y(f / gain));
    }
    g.textBaseline = "alphabetic";
    g.textAlign = "center";
    for (const ms of ticks(window[0] * 1000, window[1] * 1000, small ? 4 : 8)) if (X(ms / 1000) < right - 40) g.fillText(digits(ms, 4), X(ms / 1000), h - 5);
    g.textAlign = "right";
    g.fillText("ms", right, h - 5);
    g.fillText(small ? "● communication points" : "● communication points     thin: both sides stepped together (reference)", right, 12);
    g.textAlign = "left";
    g.fillStyle = ink;
    g.font = "600 12px system-ui,sans-serif";
    g.fillText(`${of.force.label} (${of.force.unit})`, 4, 12);
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
        g.textAlign = X(when) > w - 90 ? "right" : "left";
        g.fillText("✕ fails", X(when) + (X(when) > w - 90 ? -5 : 5), bottom - 8 - 16 * k);
      }
      // How far a curve goes that leaves the picture.
      if (!run?.rows) return;
      const values = run.columns[name].subarray(row(run, window[0]), row(run, window[1]) + 1);
      const most = values.reduce((most, f) => ((f > high || f < low) && Math.abs(f) > Math.abs(most) ? f : most), 0);
      if (!most) return;
      g.font = "700 12px system-ui,sans-serif";
      g.fillStyle = colors[k];
      g.textAlign = "right";
      const far = Math.abs(most) > 1e6 * Math.max(Math.abs(high), Math.abs(low));
      g.fillText(`${most > 0 ? "↑" : "↓"} to ${far ? "far off" : `${digits(most * gain, 3)} ${of.force.unit}`}`, right - 4, most > 0 ? top + 12 + 16 * k : bottom - 8 - 16 * k);
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
  const drawCourse = (element, { of, reference, runs, colors, window, t }) => {
    const { g, w, h } = drawing.canvas(element), name = of.force.column, T = end(reference);
    const [left, right, top, bottom] = [6, w - 6, 13, h - 15], [low, high] = extent(reference.columns[name]), pad = 0.15 * (high - low || 1);
    const X = (t) => left + (t / T) * (right - left), Y = (f) => bottom - ((f - low + pad) / (high - low + 2 * pad)) * (bottom - top);
    const [ink, soft, lens] = ["ink", "soft", "lens"].map(drawing.ink);
    g.fillStyle = lens;
    g.strokeStyle = soft;
    g.lineWidth = 1;
    g.fillRect(X(window[0]), top, X(window[1]) - X(window[0]), bottom - top);
    g.strokeRect(X(window[0]), top, X(window[1]) - X(window[0]), bottom - top);
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
  // A dot where a scheme is usable, a ring where it completes, a cross where it fails, a speck where it is not known.
  // Where marks would lie on each other some are left out, never the one at `here`.
  const drawMap = (element, rows, colors, here) => {
    const { g, w } = drawing.canvas(element), thumb = 8;
    rows.forEach((row, k) => {
      const every = Math.ceil((9 * (row.length - 1)) / (w - 2 * thumb));
      row.forEach((state, i) => {
        if ((i - here) % every) return;
        const x = thumb + (i / (row.length - 1)) * (w - 2 * thumb), y = 5 + 10 * k;
        g.strokeStyle = g.fillStyle = colors[k];
        g.lineWidth = 1.7;
        g.beginPath();
        if (state === "unknown") {
          g.fillStyle = drawing.ink("line");
          g.fillRect(x - 1.5, y - 1.5, 3, 3);
        } else if (state === "fails") {
          g.moveTo(x - 3, y - 3);
          g.lineTo(x + 3, y + 3);
          g.moveTo(x + 3, y - 3);
          g.lineTo(x - 3, y + 3);
          g.stroke();
        } else {
          g.arc(x, y, state === "usable" ? 3.2 : 2.8, 0, 7);
          if (state === "usable") g.fill(); else g.stroke();
        }
      });
    });
  };
  return { event, drawEvent, drawCourse, drawMap };
})();
