"""Scores a trajectory by the rows of a problem pack, with NumPy alone: python score.py FILE.csv [--problem DIR] [--phase P]

FILE.csv (or .csv.gz) has one row per communication point: time_s and, by the names in score.json, position, velocity and force
of each interface row, the actuator's own force at that instant; the force that the mechanics received over the step that ends
there; and perhaps work_sent_j of the actuator and work_received_j of the mechanics, both from the start on."""
import argparse, csv, gzip, json, sys
from pathlib import Path
import numpy as np

Refused = type("Refused", (Exception,), {"__doc__": "Why a file is no result: nothing is scored."})
rms = lambda x: float(np.sqrt(np.sum(x * x) / len(x)))


def table(path):
    opened = gzip.open if str(path).endswith(".gz") else open
    try:
        with opened(path, "rt", newline="") as file:
            rows = [row for row in csv.reader(file) if row]
        names = [name.strip() for name in rows[0]]
        data = np.array([[float(cell or "nan") for cell in row] for row in rows[1:]])
    except (ValueError, IndexError, UnicodeDecodeError, gzip.BadGzipFile) as error:
        raise Refused(f"{path}: not a table of numbers under names: {error}") from None
    if len(set(names)) != len(names) or data.ndim != 2 or data.shape[1] != len(names) or len(data) < 2:
        raise Refused(f"{path}: columns and header do not fit, or there are fewer than two rows")
    return {name: data[:, k] for k, name in enumerate(names)}


def between(times, columns, t):
    """Columns of a reference at times t: cubic between rows and piece by piece, a piece ending where two rows have one time;
    of the three cubics that cover t the middle one, unless another has a third difference of less than a quarter."""
    n, one_piece = len(times), times[1:] > np.nextafter(times[:-1], np.inf)
    passed = np.searchsorted(times, t, side="right")
    low, high = np.maximum(passed, 1) - 1, np.minimum(passed, n - 1)
    inside = (t > times[low]) & (t < times[high])
    joined = lambda k: (k >= 0) & (k < n - 1) & one_piece[np.clip(k, 0, n - 2)]
    left = joined(low - 1) * (1 + joined(low - 2).astype(int))
    right = joined(low + 1) * (1 + joined(low + 2).astype(int))

    def through(first, rows):
        at = [times[np.clip(first + j, 0, n - 1)] for j in range(rows)]
        difference, value = [], []
        for j in range(rows):
            apart, ahead = np.ones(len(t)), np.ones(len(t))
            for k in (k for k in range(rows) if k != j):
                apart, ahead = apart * (at[j] - at[k]), ahead * (t - at[k])
            difference.append(1 / apart)
            value.append(difference[-1] * ahead)
        total = lambda y, base, w: sum((w[j] * (y[np.clip(first + j, 0, n - 1)] - base) for j in range(rows)), 0.0)
        return total, difference, value  # a sum over rows, with weights of the highest difference or of the value

    few, found = left + right < 2, []
    with np.errstate(divide="ignore", invalid="ignore"):
        short = [(few & (left + right == m - 2), through(low - left, m)) for m in (2, 3)]
        of = [((left > 0) & (right > 0), through(low - 1, 4)), (left > 1, through(low - 2, 4)), (right > 1, through(low, 4))]
        for y in columns:
            base = y[low]
            offset, least = np.zeros(len(t)), np.full(len(t), np.inf)
            for which, (there, (total, difference, value)) in enumerate(of):
                third = np.abs(total(y, base, difference))
                take = there & ~few & (third < least)
                offset = np.where(take, total(y, base, value), offset)
                least = np.where(take, 0.25 * third if which == 0 else third, least)
            for there, (total, _, value) in short:
                offset = np.where(there, total(y, base, value), offset)
            found.append(np.where(inside, base + offset, base))
    return found


def grid_of(t, end, phase):
    """Checks t_0 = 0, t_k = (phase + k - 1) H, the last at the end: rows that are missing or moved are refused."""
    if not np.all(np.isfinite(t)) or t[0] != 0 or np.any(np.diff(t) <= 0) or t[-1] > end * (1 + 1e-9):
        raise Refused(f"time_s: must rise from 0 to at most {end} s, and be finite")
    step = float(np.median(np.diff(t)[1:])) if len(t) > 3 else float(max(np.diff(t)))
    found = 1.0 if len(t) == 2 else float(t[1] / step)
    off = np.abs(t[1:] - np.minimum((found + np.arange(len(t) - 1)) * step, end))
    if found > 1 + 1e-6 or off.max() > 1e-6 * step:
        raise Refused(f"time_s: no grid with H = {step:.6g} s: row {int(off.argmax()) + 1} is off by {off.max():.2g} s")
    if phase is not None and abs(found - phase) > 1e-6:
        raise Refused(f"time_s: the first step is {found:.6g} H, and must be {phase:.6g} H")
    return step, min(found, 1.0)


def check(row, run, step):
    """Refuses what is not this row of this problem in SI units, whatever its error would be."""
    names = [row[key] for key in ("position", "velocity", "force")]
    for name, start, bound in zip(names[:2], row["start"], row["bounds"]):
        if not abs(run[name][0] - start) <= 1e-6 * (abs(start) + 1e-3 * (bound or 0)):
            raise Refused(f"{name}: begins with {run[name][0]:.9g}, and the problem with {start:.9g}; SI units, one column each")
    for name in names:
        told = run[name][np.isfinite(run[name])]
        if len(np.unique(told)) > 20 and all(float(f"{x:.6g}") == x for x in told):
            raise Refused(f"{name}: has six digits or fewer; give nine or more")
    x, w = run[names[0]], run[names[1]]
    moved, end, start = np.diff(x), np.diff(run["time_s"]) * w[1:], np.diff(run["time_s"]) * w[:-1]
    fine = np.isfinite(moved + end + start)
    off = np.min(np.abs([moved - end, moved - start, moved - 0.5 * (end + start)]), axis=0)[fine]
    size = np.max(np.abs([moved, start, end]), axis=0)[fine]
    if np.sum(off) > 0.5 * np.sum(size) and np.sum(size) > 1e-6 * (row["bounds"][0] or 0):
        raise Refused(f"{names[1]}: is not the rate of {names[0]}: columns exchanged, or not in SI units")


def score(pack, file, phase=None):
    rule = json.loads((Path(pack) / "score.json").read_text())
    run, known, end = table(file), table(Path(pack) / "reference.csv.gz"), rule["duration_s"]
    needed = ["time_s"] + [row[key] for row in rule["rows"] for key in ("position", "velocity", "force")]
    if missing := [name for name in needed if name not in run]:
        raise Refused(f"columns missing: {', '.join(missing)}; there are: {', '.join(run)}")
    t, (step, phase) = run["time_s"], grid_of(run["time_s"], end, phase)
    near = np.any([t < 0] + [(t >= a) & (t <= b) for a, b in rule["touch_downs_s"]], axis=0)
    found, diverged = {}, []
    for row in rule["rows"]:
        names, share = [row[key] for key in ("position", "velocity", "force")], lambda x, peak: x / peak if peak else None
        check(row, run, step)
        beyond = [~(np.abs(run[name]) <= (np.inf if bound is None else bound)) for name, bound in zip(names, row["bounds"])]
        diverged += [float(t[where.argmax()]) for where in beyond if where.any()]
        force, times, peak, down = known[names[2]], known["time_s"], row["force_peak_n"], row["touch_down_peak_n"]
        impulse = np.concatenate(([0.0], np.cumsum(0.5 * np.diff(times) * (force[1:] + force[:-1]))))
        *exact, delivered = between(times, [known[name] for name in names] + [impulse], t)
        position, velocity, error = (run[name] - own for name, own in zip(names, exact))
        of_row = {
            "force_error_rms_n": rms(error), "force_error_l1_n": float(np.mean(np.abs(error))),
            "force_error_max_n": float(np.max(np.abs(error))), "force_error_rms_of_peak": share(rms(error), peak),
            "force_error_rms_of_event_peak": share(rms(error), down or peak),
            "touch_down_peak_ratio": share(float(np.max(np.abs(run[names[2]][near]))), down) if near.any() else None,
            "velocity_error_rms_m_s": rms(velocity), "position_error_rms_m": rms(position), "position_error_end_m": float(position[-1])}
        if row["received"] in run:
            lag = np.cumsum(np.diff(t, prepend=t[0]) * run[row["received"]]) - delivered
            first = np.searchsorted(t, t - 20e-3 * (1 - 1e-9), side="right") - 1
            if (first >= 0).any():
                of_row["impulse_error_20ms_n_s"] = float(np.max(np.abs(lag - lag[first])[first >= 0]))
        for name, value in of_row.items():
            found.setdefault(name, []).extend([value] if value is not None else [])
    scores = {name: max(values, key=lambda x: np.inf if np.isnan(x) else abs(x)) for name, values in found.items() if values}
    if "work_sent_j" in run and "work_received_j" in run:
        scores["interface_residual_j"] = float(run["work_sent_j"][-1] - run["work_received_j"][-1])
    whole = t[-1] >= end - step * (1 + 1e-6)  # a master of fixed steps ends with its last whole step
    return {"problem": rule["problem"], "version": rule["version"], "macro_step_s": step, "phase": phase, "points": len(t),
            "outcome": "diverged" if diverged else "completed" if whole else "ended-early",
            "diverged_at_s": min(diverged, default=None), **scores}


if __name__ == "__main__":
    (options := argparse.ArgumentParser()).add_argument("file")
    options.add_argument("--problem", default=Path(__file__).parent)
    options.add_argument("--phase", type=float)
    given = options.parse_args()
    try:
        print(json.dumps(score(given.problem, given.file, given.phase), indent=1))
    except (Refused, OSError, KeyError, ValueError) as error:
        sys.exit(f"refused: {error}")
