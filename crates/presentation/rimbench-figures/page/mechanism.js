// The figure of the mechanism: t_k stays, the end of the macro step is dragged, and belief and truth part. What is drawn is what the
// module computed, by the rules of `mechanism_figure.rs`.
(async () => {
  "use strict";
  const steps = [...document.querySelectorAll("figure.plot g.step")], canvas = steps[0]?.closest(".canvas");
  if (!steps.length || !("DecompressionStream" in window && "WebAssembly" in window && "Worker" in window)) return;
  const [RIGHT, WRONG, INK, SOFT] = [[0, 99, 156], [184, 74, 0], [34, 38, 43], [91, 98, 106]], rgb = (color) => `rgb(${color})`;
  const light = (color, share) => rgb(color.map((part) => Math.round(part + (255 - part) * share)));
  const svg = canvas.querySelector("svg"), [, , width] = svg.getAttribute("viewBox").split(" ").map(Number);
  const line = (points, color, thick, more = "") => `<path fill="none" stroke="${rgb(color)}" stroke-width="${thick}" ${more}d="M${points.map((p) => p.map((n) => n.toFixed(1))).join("L")}"/>`;
  const area = (points, fill, more = "") => `<path fill="${fill}" ${more}d="M${points.map((p) => p.map((n) => n.toFixed(1))).join("L")}z"/>`;
  const disc = ([x, y], r, fill, color, thick) => `<circle cx="${x.toFixed(1)}" cy="${y.toFixed(1)}" r="${r}" fill="${fill}" stroke="${rgb(color)}" stroke-width="${thick}"/>`;
  const text = (words, x, y, color, more = 'font-size="11.5"') => `<text x="${x}" y="${y}" fill="${rgb(color)}" ${more}>${words}</text>`;
  const cut = ([left, top, w, h], inside) => `<svg x="${left}" y="${top}" width="${w}" height="${h}" viewBox="${left} ${top} ${w} ${h}">${inside}</svg>`;
  const force = (newtons) => (Math.abs(newtons) >= 1e4 ? `${(newtons / 1e3).toFixed(1)} kN` : `${newtons.toFixed(0)} N`).replace("-", "−").replace(/^−(0 )/, "$1");
  const most = (rows, key) => Math.max(...rows.map((row) => Math.abs(row[key])));
  // The first numbers of a path: the place of a part, as the figure has it.
  const place = (part, k) => part.querySelectorAll("path")[k].getAttribute("d").match(/-?[\d.]+/g).map(Number);
  // Every column has a worker of its own, so that what happens in it is computed once.
  const alive = steps.map((step, index) => {
    const [name, contact, ...numbers] = step.dataset.step.split(" "), [start, end, longest] = numbers.map((number) => Number(Number(number).toPrecision(9)));
    const lanes = [...step.querySelectorAll(".lane")], forces = step.querySelector(".forces"), span = step.querySelector(".span");
    const [scale, beyond] = forces.dataset.forces.split(" ").map(Number), plot = place(forces, 0), [, zero] = place(forces, 1), [, tick] = place(span, 0);
    const [left, , wide] = place(lanes[0], 0), x = (t) => left + 14 + ((wide - 28) * (t - start)) / (end - start);
    const names = [...forces.querySelectorAll(".series")].map((group) => group.dataset.series);
    let truth;
    const draw = (beliefs) => {
      const all = [beliefs[0].happens, ...beliefs.map(({ believed }) => believed)], own = all[0];
      truth ??= own;
      const opens = truth.at(-1).gap > truth[0].gap, closed = 0.01 * most(truth, "gap"), last = own.at(-1);
      const colors = all.map((rows, k) => (!k ? INK : Math.abs(rows.at(-1).force - last.force) <= 0.01 * most(own, "force") ? RIGHT : WRONG));
      const said = all.map((rows) => {
        const { gap } = rows.at(-1), pull = Math.min(0, ...rows.map((row) => row.contact)), away = gap > closed;
        if (gap < -closed) return ["sinks in"];
        if (opens) return away ? ["lifts off", `by ${(1e6 * gap).toFixed(gap < 1e-6 ? 1 : 0)} µm`] : pull < 0 ? ["pulls it down", `with ${force(-pull)}`] : ["stands still"];
        return away ? [gap < rows[0].gap - closed ? "falls" : "hangs in air"] : [`falls ${(1e6 * rows[0].gap).toFixed(0)} µm`, "and lands"];
      });
      all.forEach((rows, k) => {
        const [, top, , high] = place(lanes[k], 0), [, ground] = place(lanes[k], 1), color = colors[k], up = (opens ? 20 : 11) / most(truth, "gap");
        const at = ({ time, gap }) => [x(time), ground - up * gap], real = own.map(({ time, gap }) => at({ time, gap: Math.max(gap, 0) })), path = rows.map(at);
        const shown = [...new Set([0, 1, 2, 3, 4, 5].map((strobe) => Math.min(Math.floor((longest * strobe) / 5), rows.length - 1)))].map((row) => rows[row]);
        const acts = rows.some((row) => row.acts), welded = acts && color === WRONG && rows.some((row, j) => row.contact < 0 || (j && row.contact && row.gap > closed));
        const inside = [color === WRONG ? area([...path, ...[...real].reverse()], light(color, 0.72)) : ""];
        for (const row of shown) {
          const [px, py] = at(row);
          inside.push(opens ? disc([px, py - 9], 9, light(color, 0.8), color, 1.4) : area([[px - 9, py - 15], [px + 9, py - 15], [px, py]], light(color, 0.8), `stroke="${rgb(color)}" stroke-width="1.4" `));
        }
        if (k) inside.push(line(real, INK, 1.3, 'stroke-dasharray="4 3" '));
        inside.push(line(path, color, 2));
        for (const row of acts ? shown : []) {
          const [px, py] = at(row);
          if (welded) inside.push(line([[px, py], [px, ground]], color, 3.6), area([[px - 6, ground], [px, ground - 7], [px + 6, ground]], rgb(color)));
          else if (py < top + high - 3) inside.push(disc([px, py], 3.4, Math.abs(row.gap) <= closed ? rgb(color) : "#fff", color, 1.5));
        }
        const beside = left + wide + 7, sign = color === RIGHT ? "l3.5 4 6-9" : "m1-4.5l8 8m0-8l-8 8";
        const words = said[k].map((words, j) => text(words, beside + (k ? 15 : 0), top + 41 + 14 * j, k ? color : SOFT)).join("");
        const [back, floor, level] = lanes[k].querySelectorAll("path");
        lanes[k].replaceChildren(back, floor, level);
        lanes[k].insertAdjacentHTML("beforeend", cut([left, top, wide, high], inside.join("")) + text(force(rows.at(-1).force), beside, top + 24, color, 'font-size="13" font-weight="600"') + (k ? `<path fill="none" stroke="${rgb(color)}" stroke-width="2" d="M${beside} ${top + 37}${sign}"/>` : "") + words);
      });
      const curve = (rows) => rows.map((row) => [x(row.time), zero - scale * row.force]), ends = [], [, top, , high] = plot;
      const curves = [line(curve(own), SOFT, 6, 'stroke-opacity=".45" ')], labels = [];
      names.forEach((name, k) => {
        const rows = all[k + 1], color = colors[k + 1], y = zero - scale * rows.at(-1).force;
        curves.push(`<g class="series" data-series="${name}">${line(curve(rows), color, 2)}</g>`);
        if (most(rows, "force") > beyond) return labels.push(text(`${name}: ${force(rows.at(-1).force)}`, left + 26, top + 13, color));
        const same = ends.find((end) => Math.abs(end.y - y) < 4 && end.color === color);
        if (same) same.names.push(name);
        else ends.push({ y, color, names: [name] });
      });
      let below = top;
      for (const { y, color, names } of ends.sort((a, b) => a.y - b.y)) {
        const first = Math.min(Math.max(y - 6 * (names.length - 1), below), top + high - 13 * names.length + 8);
        names.forEach((name, j) => labels.push(text(name, left + wide + 7, first + 13 * j + 4.2, color)));
        below = first + 13 * names.length;
      }
      const [back, level] = forces.querySelectorAll("path");
      forces.replaceChildren(back, level);
      forces.insertAdjacentHTML("beforeend", cut(plot, curves.join("")) + labels.join(""));
      const length = `${(1e3 * (last.time - start)).toFixed(2).replace(/\.?0+$/, "")} ms`;
      // Beside a macro step that is too short for the words.
      const [from, to] = [x(start), x(last.time)], [middle, anchor] = to - from < 130 ? [to + 8, "start"] : [(from + to) / 2, "middle"];
      span.innerHTML = text(`${length}, no exchange`, middle, tick + 13, SOFT, `font-size="11.5" text-anchor="${anchor}"`) + [from, to].map((at) => line([[at, tick], [at, tick + 7]], SOFT, 1.2)).join("");
      const judged = names.map((name, k) => `${name} ${colors[k + 1] === RIGHT ? "right" : "wrong"}, ${force(all[k + 1].at(-1).force)}`);
      slider.setAttribute("aria-valuetext", `${length}: ${judged.join("; ")}; what happens ${force(last.force)}`);
      canvas.closest("figure").classList.toggle("moved", Number(slider.value) < longest);
      step.dataset.drawn = slider.value;
    };
    // One request at a time; the last place of the hand is the next.
    let simulator, busy = false;
    const rowsOf = ({ words, numbers }) => {
      const columns = words.match(/^columns (.*)$/m)[1].split(" "), [time, gap, own, sent] = ["time_s", `gap_${contact}_m`, `contact_force_${contact}_n`, "actuator_force_n"].map((column) => columns.indexOf(column));
      const acting = columns.flatMap((column, k) => (column.startsWith("contact_force_") ? [k] : []));
      const rows = Array.from({ length: numbers.length / columns.length }, (_, k) => numbers.subarray(k * columns.length, (k + 1) * columns.length));
      const all = rows.map((row) => ({ time: row[time], gap: row[gap], contact: row[own], force: row[sent], acts: acting.some((k) => row[k] !== 0) })), half = all.length / 2;
      return { happens: all.slice(0, half), believed: all.slice(half) };
    };
    const ask = (count) =>
      new Promise((resolve, reject) => {
        const request = (lane) => {
          const [scheme, contacts] = lane.dataset.lane.split(" ");
          return `believe ${start}\ncase ${name}\nmacro_step_s ${(((end - start) * count) / longest).toPrecision(9)}\nscheme ${scheme}\n${contacts ? `contact_detection ${contacts}\n` : ""}`;
        };
        simulator.onmessage = ({ data }) => {
          const wrong = data.answers.find(({ words }) => words.startsWith("error"));
          if (wrong) reject(new Error(wrong.words)); else resolve(data.answers.map(rowsOf));
        };
        simulator.postMessage({ requests: lanes.slice(1).map(request) });
      });
    const follow = async () => {
      slider.value = Math.max(slider.value, 4);
      if (busy) return;
      busy = true;
      try {
        simulator ??= await started();
        // What happens is known over the longest step first: the scales of the column are those of that step.
        if (!truth) truth = (await ask(longest))[0].happens;
        for (let count; (count = Number(slider.value)) !== Number(step.dataset.drawn); ) draw(await ask(count));
      } catch (error) {
        slider.disabled = true;
        slider.title = error.message;
      }
      busy = false;
    };
    const started = () =>
      page.simulator().then(({ worker, begin }) => new Promise((resolve, reject) => {
        worker.onerror = () => reject(new Error("the worker does not start"));
        worker.onmessage = ({ data }) => (data.failed ? reject(new Error(data.failed)) : resolve(worker));
        begin();
      }));
    const title = index ? "a contact closes" : "a contact opens", slider = page.make("input", { type: "range", min: 0, max: longest, value: longest, step: 1, "aria-label": `Macro step in which ${title}`, "aria-valuetext": `${1e3 * (end - start)} ms` });
    // The middle of its handle is where the macro step ends.
    slider.style.left = `calc(${(100 * (left + 14)) / width}% - 8px)`;
    slider.style.width = `calc(${(100 * (wide - 28)) / width}% + 16px)`;
    slider.addEventListener("input", follow);
    // The lanes are the slider as well.
    const pull = (event) => {
      const box = svg.getBoundingClientRect(), share = (((event.clientX - box.left) / box.width) * width - left - 14) / (wide - 28);
      slider.value = Math.round(share * longest);
      follow();
    };
    step.addEventListener("pointerdown", (event) => {
      step.setPointerCapture(event.pointerId);
      pull(event);
    });
    step.addEventListener("pointermove", (event) => step.hasPointerCapture(event.pointerId) && pull(event));
    return slider;
  });
  const row = page.make("div", { class: "steps" }, page.make("span", {}, "Drag the macro step"), ...alive);
  // What an arrow key means here, it does not mean for the values of the figure.
  row.addEventListener("keydown", (event) => event.stopPropagation());
  canvas.append(row);
})();
