// Reads traces, and says in a few words what came of a run.
const verdict = (() => {
  "use strict";
  // The row at or before a time.
  const row = (run, t) => {
    const times = run.columns.time_s;
    let low = 0, high = run.rows - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (times[middle] <= t + 1e-9) low = middle; else high = middle - 1;
    }
    return low;
  };
  const at = (run, name, t) => {
    const values = run.columns[name], times = run.columns.time_s;
    if (!values) return NaN;
    const k = row(run, t);
    if (k + 1 >= run.rows || t <= times[k]) return values[k];
    return values[k] + Math.min((t - times[k]) / (times[k + 1] - times[k]), 1) * (values[k + 1] - values[k]);
  };
  const end = (run) => (run?.rows ? run.columns.time_s[run.rows - 1] : 0);
  const extent = (values) => values.reduce(([low, high], v) => [Math.min(low, v), Math.max(high, v)], [Infinity, -Infinity]);
  const peak = (run, name) => (run[`peak ${name}`] ??= run.columns[name].subarray(0, run.rows).reduce((most, v) => Math.max(most, Math.abs(v)), 0));
  const digits = (value, n = 2) => String(Number(value.toPrecision(n))).replace("-", "−");
  const millimetres = (metres) => (metres < 1e-4 ? `${digits(1e6 * metres)}\u00a0µm` : metres < 0.1 ? `${digits(1000 * metres)}\u00a0mm` : `${digits(metres)}\u00a0m`);
  const milliseconds = (ms) => (ms < 0.1 ? `${digits(1000 * ms, 3)}\u00a0µs` : `${digits(ms, 3)}\u00a0ms`);
  const seconds = (t) => (t < 1 ? milliseconds(1000 * t) : `${t.toFixed(2)}\u00a0s`);
  // The program's bounds: what stays down, and which share of the peak an error may be. A run is usable within it, else completes or fails.
  const { stays_down_m, usable } = JSON.parse(document.getElementById("known").textContent);
  const SIGNS = { usable: "●", completes: "○", fails: "✕" };
  const judge = (run, of) => {
    if (run.verdict) return run.verdict;
    const facts = run.facts, column = of.force.column;
    // What it counts as is said by the program, which knows every outcome.
    const counts_as = facts.get("outcome_class");
    if (facts.has("error") || counts_as === "no-answer" || !run.rows) {
      const why = facts.get("error") ?? facts.get("reason") ?? "";
      return (run.verdict = { none: true, failed: false, when: null, state: "fails", sign: "–", numbers: why, words: run.rows > 1 ? "no answer" : "not run", why });
    }
    const failed = counts_as === "failed";
    const when = failed ? Number(facts.get("outcome_at_s") ?? end(run)) : null;
    // What a run does after it has failed is not shown: it is over.
    if (failed) run.rows = row(run, when) + 1;
    // Without a share there is no force to speak of, and no ratio of peaks either.
    const share = facts.get("force_error_rms_of_peak") ?? "", error = Number(share), touch = Number(facts.get("touch_down_peak_ratio") ?? NaN);
    const ratio = share === "" ? 0 : peak(run, column) / Number(facts.get("reference_force_peak_n"));
    const opened = Number(facts.get("lift_off_height_m") ?? 0);
    const [opens, stays] = of.contact ?? ["", ""], moved = opens && opened > stays_down_m ? `${opens} ${millimetres(opened)}` : "";
    const of_force = ratio > 1.5 ? `force ${ratio > 1000 ? "far" : `${digits(ratio)}×`} too high` : "";
    // How a run failed is said by the program, which knows its own limits, and why in the hint.
    const parts = (failed ? [`${facts.get("outcome").replaceAll("-", " ")} at ${seconds(when)}`] : [moved || stays, of_force]).filter(Boolean);
    // The error over the whole run, and what it hides: the peak of the touch-down, or of the run where nothing touches down.
    const peaks = Number.isFinite(touch) ? touch : ratio, percent = Math.round(100 * Math.abs(peaks - 1));
    // The reference is known to a tenth of what is shown; where it is not, the error is at most what both make.
    const [force, known] = ["force_error_rms_n", "reference_force_uncertainty_n"].map((key) => Number(facts.get(key)));
    const most = known > 0.1 * force ? 1 + known / force : 0;
    const rms = `error ${most ? "≤\u00a0" : ""}${digits(100 * error * (most || 1))}\u00a0%\u00a0rms`, high = peaks > 1 ? "high" : "low", height = peaks > 2 ? `${digits(peaks)}×` : `${percent}\u00a0% too ${high}`;
    // A run that failed is told by how far its force was gone by then.
    const far = peak(run, column) / Number(facts.get("reference_force_peak_n"));
    const gone = !Number.isFinite(far) ? "" : `force ${far > 1000 ? "far beyond" : `${digits(far)}×`} the true peak`;
    const numbers = failed ? gone : share === "" ? facts.get("without_peak") ?? "no force to speak of" : `${rms}, ${Number.isFinite(touch) ? "touch-down peak" : "peak"} ${percent ? height : "exact to 1\u00a0%"}`;
    // An error over the whole run hides an event: half of its peak must be there as well.
    const follows = share !== "" && error <= usable, state = failed ? "fails" : follows && percent <= 50 ? "usable" : "completes";
    if (!parts.length) parts.push(!follows ? "leaves the reference" : percent > 25 ? "follows the reference, not its peak" : "follows the reference");
    return (run.verdict = { none: false, failed, when, state, error: share === "" ? null : error * (most || 1), sign: SIGNS[state], numbers, words: parts.join(", "), why: `${facts.get("outcome")}: ${facts.get("reason") ?? ""}` });
  };
  // The answer in words, from the states of a scheme at every step that is offered, the shortest first. Usable *to* a step means usable at
  // it and at every shorter one, and so does *completes to*, which is told where it is at least twice as far. Nothing is said of what is
  // not known yet.
  const answer = (states, steps_ms) => {
    const reach = (good) => {
      const first = states.findIndex((state) => !good.includes(state));
      return { to: first < 0 ? states.length - 1 : first - 1, known: states[first] !== "unknown" };
    };
    const [usable, completes] = [reach(["usable"]), reach(["usable", "completes"])], at = (k) => milliseconds(steps_ms[k]);
    if (!usable.known) return "computing …";
    const said = usable.to < 0 ? "usable at no step tried" : `usable to ${at(usable.to)}`;
    if (usable.to === states.length - 1) return `${said}, the longest tried.`;
    const more = completes.to >= 0 && (usable.to < 0 || steps_ms[completes.to] >= 2 * steps_ms[usable.to]);
    return `${said}${!completes.known ? " …" : more ? `, completes to ${at(completes.to)}.` : "."}`;
  };
  return { answer, usable, length: millimetres, row, at, end, extent, peak, digits, milliseconds, seconds, judge };
})();
