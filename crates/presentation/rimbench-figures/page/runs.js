// The table of runs, and the drawer of one run: what it was, what came of it, and the same run in this page.
(async () => {
  "use strict";
  const $ = (id) => document.getElementById(id);
  const { make, shown } = page;
  let studies;
  try {
    ({ studies } = await page.data);
  } catch (error) {
    $("runs-missing").textContent = `The table of runs cannot be shown: ${error.message}.`;
    return;
  }
  const runs = [];
  studies.forEach((study, number) => {
    if (!study.count) return;
    study.names = study.ids.trim().split(" ");
    for (let row = 0; row < study.count; row++) runs.push({ study, number, row });
  });
  if (!runs.length) {
    $("runs-missing").textContent = "There is no run to show here; see what is missing.";
    document.body.dataset.runs = "none";
    return;
  }
  const setting = ({ study, row }, name) => {
    const [values, indices] = study.settings[name] ?? [[""]];
    return values[indices ? indices[row] : 0];
  };
  const metric = ({ study, row }, name) => study.metrics[name]?.[row] ?? null;
  const name = ({ study, row }) => study.names[row];

  // ---- the columns
  const milliseconds = (run) => Number((Number(setting(run, "macro_step_s")) * 1e3).toPrecision(6));
  const COLUMNS = [
    ["run", (run) => name(run)],
    ["study", (run) => run.study.name],
    ["case", (run) => [setting(run, "case"), setting(run, "set")].filter(Boolean).join(", ")],
    ["scheme", (run) => setting(run, "label")],
    ["H (ms)", milliseconds],
    ["phase", (run) => Number(setting(run, "phase") || 1)],
    ["outcome", (run) => setting(run, "outcome")],
    ["force error (N)", (run) => metric(run, "force_error_rms_n")],
    ["position error (m)", (run) => metric(run, "position_error_rms_m")],
  ];
  let sorted = null, down = false, claim = null, many = 50, list = runs;
  const heads = COLUMNS.map(([title], k) => {
    const button = make("button", { type: "button" }, title);
    const head = make("th", { scope: "col", "aria-sort": "none" }, button);
    button.addEventListener("click", () => {
      [down, sorted] = [sorted === k ? !down : false, k];
      heads.forEach((other, index) => other.setAttribute("aria-sort", index === k ? (down ? "descending" : "ascending") : "none"));
      show();
    });
    return head;
  });
  $("runs-head").append(...heads);

  // ---- filters
  const FILTERS = { study: (run) => run.study.name, case: (run) => setting(run, "case"), label: (run) => setting(run, "label"), outcome: (run) => setting(run, "outcome") };
  for (const [key, of] of Object.entries(FILTERS)) {
    const values = [...new Set(runs.map(of))].sort();
    $(`runs-${key}`).append(new Option("all", ""), ...values.map((value) => new Option(value, value)));
    $(`runs-${key}`).addEventListener("input", () => again());
  }
  $("runs-text").addEventListener("input", () => again());
  const words = (run) => [name(run), ...Object.keys(run.study.settings).map((key) => setting(run, key))].join(" ").toLowerCase();
  const again = () => {
    many = 50;
    show();
  };
  const show = () => {
    const wanted = Object.entries(FILTERS).map(([key, of]) => [of, $(`runs-${key}`).value]).filter(([, value]) => value);
    const sought = $("runs-text").value.toLowerCase().split(/\s+/).filter(Boolean);
    list = claim ? claim.rows.map((row) => ({ study: studies[claim.number], number: claim.number, row })) : runs;
    list = list.filter((run) => wanted.every(([of, value]) => of(run) === value) && sought.every((word) => words(run).includes(word)));
    if (sorted !== null) {
      const keyed = list.map((run) => [COLUMNS[sorted][1](run), run]);
      const place = (value) => (value === null || Number.isNaN(value) ? Infinity : value);
      const order = (a, b) => (typeof a === "string" ? a.localeCompare(b) : place(a) === place(b) ? 0 : place(a) - place(b));
      keyed.sort(([a], [b]) => (down ? order(b, a) : order(a, b)));
      list = keyed.map(([, run]) => run);
    }
    const rows = list.slice(0, many).map((run) => {
      const open = make("button", { type: "button", class: "open" }, name(run));
      open.addEventListener("click", () => drawer(run));
      const cells = COLUMNS.slice(1).map(([, of]) => of(run));
      return make("tr", {}, make("td", {}, open), ...cells.map((value) => make("td", typeof value === "string" ? {} : { class: "number" }, typeof value === "string" ? value : shown(value))));
    });
    $("runs-body").replaceChildren(...rows);
    const of = claim ? ` of the claim “${claim.text}”` : "";
    $("runs-count").textContent = `${list.length} ${list.length === 1 ? "run" : "runs"}${of}, ${rows.length} shown`;
    $("runs-more").hidden = rows.length === list.length;
  };
  $("runs-more").addEventListener("click", () => {
    many += 200;
    show();
  });
  $("runs-all").addEventListener("click", () => {
    claim = null;
    for (const key of [...Object.keys(FILTERS), "text"]) $(`runs-${key}`).value = "";
    again();
  });
  for (const button of document.querySelectorAll(".show-runs")) {
    const [number, index] = button.dataset.claim.split(",").map(Number);
    const [text, ends] = studies[number].claims?.[index] ?? ["", []];
    // First and last of each stretch.
    const rows = ends.flatMap((from, k) => (k % 2 ? [] : Array.from({ length: ends[k + 1] - from + 1 }, (_, at) => from + at)));
    if (!rows.length) continue;
    button.hidden = false;
    button.addEventListener("click", () => {
      claim = { number, text, rows };
      for (const key of [...Object.keys(FILTERS), "text"]) $(`runs-${key}`).value = "";
      again();
      page.reveal($("runs-work"));
      $("runs-body").querySelector("button")?.focus({ preventScroll: true });
    });
  }
  $("runs-missing").hidden = true;
  $("runs-work").hidden = false;
  show();

  // ---- one run
  const OUTCOME = ["label", "outcome", "outcome_at_s", "reason"];
  // Said of runs with a model, of which it was an option once.
  const SETTLED = ["redundancy"];
  // Settings that make a run, as the options of a request.
  const request = (run) => {
    const lines = [];
    for (const key of Object.keys(run.study.settings).filter((key) => !OUTCOME.includes(key) && !SETTLED.includes(key))) {
      const value = setting(run, key);
      if (!value) continue;
      if (key === "set") lines.push(...value.split(" ").map((pair) => `set.${pair.replace("=", " ")}`));
      else lines.push(`${key} ${value}`);
    }
    return lines;
  };
  // A word as a shell takes it.
  const quoted = (word) => (/^[\w.,:+/=@%-]+$/.test(word) ? word : `'${word.replaceAll("'", "'\\''")}'`);
  const command = (run) => {
    const option = (line) => {
      const [key, value] = [line.slice(0, line.indexOf(" ")), line.slice(line.indexOf(" ") + 1)];
      return key.startsWith("set.") ? `--set ${quoted(`${key.slice(4)}=${value}`)}` : `${quoted(`--${key.replace(/_s$/, "").replaceAll("_", "-")}`)} ${quoted(value)}`;
    };
    return `cargo run --release -- simulate ${request(run).map(option).join(" ")}`;
  };
  const spoken = (key) => {
    const units = { n_s: "N s", m_s: "m/s", n: "N", m: "m", j: "J", w: "W", s: "s", kg: "kg", rad: "rad", pa: "Pa" };
    const unit = Object.keys(units).find((end) => key.endsWith(`_${end}`));
    return unit ? `${key.slice(0, -unit.length - 1).replaceAll("_", " ")} (${units[unit]})` : key.replaceAll("_", " ");
  };
  const facts = (pairs) => make("dl", {}, ...pairs.flatMap(([key, value]) => [make("dt", {}, spoken(key)), make("dd", {}, value)]));
  const SVG = "http://www.w3.org/2000/svg";
  const drawn = (trace) => {
    const { time_s: time, ...columns } = trace;
    return Object.entries(columns).map(([key, values]) => {
      const known = values.filter(Number.isFinite);
      if (!known.length) return "";
      const [low, high] = [known.reduce((a, b) => Math.min(a, b)), known.reduce((a, b) => Math.max(a, b))];
      const across = (t) => 4 + (392 * (t - time[0])) / (time.at(-1) - time[0] || 1), up = (v) => 74 - (68 * (v - low)) / (high - low || 1);
      const points = time.map((t, k) => (Number.isFinite(values[k]) ? `${across(t).toFixed(1)},${up(values[k]).toFixed(1)}` : "")).filter(Boolean).join(" ");
      const svg = document.createElementNS(SVG, "svg");
      svg.setAttribute("viewBox", "0 0 400 80");
      svg.setAttribute("role", "img");
      svg.setAttribute("aria-label", `${spoken(key)} over time, from ${shown(low)} to ${shown(high)}`);
      const line = svg.appendChild(document.createElementNS(SVG, "polyline"));
      line.setAttribute("points", points);
      return make("figure", { class: "trace" }, svg, make("figcaption", {}, `${spoken(key)}: ${shown(low)} to ${shown(high)} over ${shown(time[0])} to ${shown(time.at(-1))} s`));
    });
  };
  let current;
  const drawer = (run) => {
    current = run;
    $("run-title").textContent = `Run ${name(run)}`;
    const settings = Object.keys(run.study.settings).filter((key) => setting(run, key) !== "");
    const metrics = Object.keys(run.study.metrics).filter((key) => metric(run, key) !== null);
    const trace = run.study.traces?.[run.row];
    $("run-body").replaceChildren(
      make("p", {}, "Of study ", make("a", { href: `#${run.study.anchor}` }, run.study.name), `: ${setting(run, "outcome")}`, setting(run, "reason") ? ` (${setting(run, "reason")})` : "", "."),
      make("h3", {}, "Measured"),
      metrics.length ? facts(metrics.map((key) => [key, shown(metric(run, key), 6)])) : make("p", {}, "Nothing: it did not complete."),
      make("h3", {}, "Parameters"),
      facts(settings.map((key) => [key, setting(run, key)])),
      make("h3", {}, "Trace"),
      ...(trace ? drawn(trace) : [make("p", { class: "soft" }, "No trace of it is in this page.")]),
    );
    $("run-body").querySelector("a").addEventListener("click", () => $("run").close());
    $("run-command").textContent = command(run);
    $("run-answer").replaceChildren();
    delete $("run-answer").dataset.digits;
    $("run-here").disabled = false;
    showLink(run);
    if (!$("run").open) $("run").showModal();
    $("run").scrollTop = 0;
  };
  // What the sliders can say of a run; nothing of one with other options.
  const showLink = (run) => {
    const link = $("run-try");
    link.hidden = !(setting(run, "case") === "wedge-box" && !setting(run, "set") && setting(run, "label") === setting(run, "scheme"));
    link.href = `#${new URLSearchParams({ h: milliseconds(run), phase: setting(run, "phase") || "1", b: setting(run, "scheme"), t: "1.735" })}`;
  };
  $("run-try").addEventListener("click", () => {
    $("run").close();
    $("try").scrollIntoView();
  });
  $("run-copy").addEventListener("click", () => page.copy($("run-command").textContent, $("run-copy")));
  $("run").addEventListener("click", (event) => event.target === $("run") && $("run").close());

  // ---- the same run here
  let asking;
  const askNow = async (text) => {
    asking ??= page.simulator().then(
      ({ worker, begin }) =>
        new Promise((resolve, reject) => {
          worker.onmessage = ({ data }) => (data.failed ? reject(new Error(data.failed)) : resolve(worker));
          worker.onerror = (event) => reject(new Error(event.message || "the worker does not start"));
          begin();
        }),
    );
    let worker;
    try {
      worker = await asking;
    } catch (error) {
      // The next may have more luck.
      asking = undefined;
      throw error;
    }
    return new Promise((resolve, reject) => {
      worker.onmessage = ({ data }) => resolve(data.answers[0]);
      worker.onerror = (event) => {
        worker.terminate();
        asking = undefined;
        reject(new Error(event.message || "the worker broke off"));
      };
      worker.postMessage({ requests: [text] });
    });
  };
  // One request after the other, so that each has its own answer, whichever run is looked at meanwhile.
  let last = Promise.resolve();
  const ask = (text) => {
    const answer = last.then(() => askNow(text));
    last = answer.catch(() => {});
    return answer;
  };
  // Numbers that no reference has a part in: the browser's must be the stored ones, digit by digit.
  const CHECKED = ["work_sent_j", "force_peak_n", "exchanges"];
  $("run-here").addEventListener("click", async () => {
    const run = current, answer = $("run-answer");
    $("run-here").disabled = true;
    answer.replaceChildren("Simulating …");
    let found;
    try {
      found = page.facts((await ask(`run\n${request(run).join("\n")}\n`)).words);
    } catch (error) {
      if (run !== current) return;
      $("run-here").disabled = false;
      answer.replaceChildren(`Simulating is not possible here: ${error.message}.`);
      return;
    }
    if (run !== current) return;
    $("run-here").disabled = false;
    if (found.has("error")) return answer.replaceChildren(`Not simulated: ${found.get("error")}`);
    const stored = CHECKED.filter((key) => metric(run, key) !== null && run.study.ids.trim().split(" ")[0].length === 16);
    const rows = [["run id", name(run), found.get("run_id").slice(0, name(run).length)], ["outcome", setting(run, "outcome"), found.get("outcome")]];
    rows.push(...stored.map((key) => [spoken(key), String(metric(run, key)), String(Number(found.get(key)))]));
    const same = rows.every(([, a, b]) => a === b);
    answer.dataset.digits = same ? "equal" : "different";
    const table = make("table", { class: "numbers" }, make("thead", {}, make("tr", {}, ...["", "stored", "in this browser", ""].map((title) => make("th", {}, title)))));
    table.append(make("tbody", {}, ...rows.map(([key, a, b]) => make("tr", {}, make("th", { scope: "row" }, key), make("td", {}, a), make("td", {}, b), make("td", {}, a === b ? "equal" : "different")))));
    const verdict = !same ? "The digits differ: results of another version, or another machine’s dense factorisation." : stored.length ? "The digits are the stored ones, to the last." : "Run id and outcome are the stored ones; this page holds no digits of it to compare.";
    const errors = ["force_error_rms_n", "position_error_rms_m"].filter((key) => found.has(key)).map((key) => `${spoken(key)} ${shown(Number(found.get(key)))}`);
    answer.replaceChildren(make("p", {}, make("strong", {}, verdict)), table, make("p", { class: "soft" }, errors.length ? `Held against the reference of this page, which is known to ±\u00a0${shown(Number(found.get("reference_force_uncertainty_n") ?? NaN))}\u00a0N: ${errors.join(", ")}.` : ""));
  });
  // The medians that are kept of a study without rows.
  for (const kept of document.querySelectorAll("details.kept"))
    kept.addEventListener("toggle", async () => {
      const [head, ...rows] = (await page.data).summaries[kept.dataset.study] ?? [];
      if (!kept.open || !head || kept.querySelector("table")) return;
      const line = (cells, kind) => make("tr", {}, ...cells.map((cell) => make(kind, {}, cell !== "" && Number.isFinite(Number(cell)) ? shown(Number(cell)) : cell)));
      const table = make("table", { class: "numbers" }, make("thead", {}, line(head.map((name) => name.replaceAll("_", " ")), "th")), make("tbody", {}, ...rows.map((row) => line(row, "td"))));
      kept.append(make("div", { class: "table tall", tabindex: "0", role: "region", "aria-label": "Medians" }, table));
    });
  document.body.dataset.runs = "ready";
})();
