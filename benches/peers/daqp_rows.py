#!/usr/bin/env python3
"""Solves contact rows and boards with daqp, in turns with our default solver; see README.md in this folder."""

import argparse
import csv
import shlex
import subprocess
import sys
import time

import numpy as np

try:
    import daqp
except ImportError as error:
    raise SystemExit(f"error: daqp is not installed ({error}); see README.md in this folder")

# Right-hand sides of a sequence, and passes over it in each turn, of which the shortest counts.
STEPS, PASSES = 16, 12


def problems(name, n):
    """H and the sequence of b, as `benches/solvers.rs` makes them."""
    rows = np.arange(n)
    row = 2.0 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    if name == "row":
        return row, [np.sin(0.3 * rows + 0.02 * step) - 0.5 for step in range(STEPS)]
    if name == "hit-row":
        return row, [np.where(rows == 0, -1.0 - 0.02 * step, 0.0) for step in range(STEPS)]
    x = 2.0 * rows / (n - 1) - 1.0 if n > 1 else np.zeros(1)
    return 1.0 + 3.0 * np.outer(x, x), [-1.0 - 2.7 * np.sin(0.02 * step) * x for step in range(STEPS)]


def solved(name, n, state):
    """The shortest pass over the sequence per problem, whole calls and inside of daqp (s), and the largest natural residual."""
    h, sequence = problems(name, n)
    bounds = np.zeros((0, n)), np.full(n, 1e30), np.zeros(n), np.zeros(n, dtype=np.int32)
    shortest, inside, worst = float("inf"), float("inf"), 0.0
    model = daqp.Model()
    model.setup(h, sequence[0], *bounds)
    for _ in range(PASSES):
        answers, within, start = [], 0.0, time.perf_counter()
        for b in sequence:
            if state == "cold":
                impulses, _, _, info = daqp.solve(h, b, *bounds)
            else:
                model.update(f=b)
                impulses, _, _, info = model.solve()
            answers.append(impulses)
            within += info["setup_time"] + info["solve_time"]
        shortest, inside = min(shortest, time.perf_counter() - start), min(inside, within)
        for b, impulses in zip(sequence, answers):
            off = np.abs(np.minimum(np.diag(h) * impulses, h @ impulses + b)).max() / np.abs(b).max()
            worst = off if not off <= worst else worst
    return shortest / STEPS, inside / STEPS, worst


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--bench", default="cargo bench -q -p rimbench-benches --bench solvers --", help="command that runs the bench of solvers")
    parser.add_argument("--turns", type=int, default=3, help="how often each has its turn; of all the shortest time counts")
    parser.add_argument("--csv", help="file that the rows are written to as well")
    arguments = parser.parse_args()
    if arguments.turns < 1:
        parser.error(f"--turns {arguments.turns}: valid: 1 or more")

    ours, theirs = {}, {}
    for _ in range(arguments.turns):
        text = subprocess.run(shlex.split(f"{arguments.bench} --csv"), check=True, stdout=subprocess.PIPE, text=True).stdout
        lines = text.splitlines()
        for row in csv.DictReader(lines[lines.index("problem,contacts,state,ours_us,ours_by_pattern_us") :]):
            key = row["problem"], int(row["contacts"]), row["state"]
            times = [row["ours_us"], row["ours_by_pattern_us"]]
            ours.setdefault(key, []).append([float(text) if text else None for text in times])
            theirs.setdefault(key, []).append(solved(*key))

    # Times in µs; inside is what daqp says of itself, without the call from Python.
    table = [["problem", "contacts", "state", "ours_us", "ours_spread", "by_pattern_us", "daqp_us", "daqp_inside_us"]]
    table[0] += ["daqp_over_ours", "inside_over_ours", "inside_over_by_pattern", "daqp_residual"]
    for key, times in ours.items():
        dense, by_pattern = zip(*times)
        call, inside, _ = (1e6 * min(part) for part in zip(*theirs[key]))
        own, pattern = min(dense), min(by_pattern) if by_pattern[0] else None
        ratios = [call / own, inside / own, inside / pattern if pattern else None]
        residual = max(worst for _, _, worst in theirs[key])
        shown = [f"{own:.3g}", f"{max(dense) / own:.2f}", *("" if x is None else f"{x:.3g}" for x in [pattern, call, inside, *ratios])]
        table.append([*key, *shown, f"{residual:.1e}"])
    csv.writer(sys.stdout, lineterminator="\n").writerows(table)
    if arguments.csv:
        with open(arguments.csv, "w", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows(table)


if __name__ == "__main__":
    main()
