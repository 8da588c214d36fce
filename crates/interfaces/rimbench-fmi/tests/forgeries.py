"""Replay holds an honest run of a pack and refuses forgeries that no look at numbers finds: python forgeries.py PACK"""
import csv, sys, tempfile
from pathlib import Path
import numpy as np

pack = Path(sys.argv[1])
sys.path[:0] = [str(pack), str(pack / "masters")]
import fmpy_loop
from replay import replay
from score import Refused, between, score, table
import json

rule = json.loads((pack / "score.json").read_text())
row, H = rule["rows"][0], rule["macro_steps_s"][0]
P, V, F, R = row["position"], row["velocity"], row["force"], row["received"]
folder = Path(tempfile.mkdtemp())
honest = folder / "honest.csv"
assert not fmpy_loop.run(pack, H, honest, "mechanics-first", rule["phases"][1])
run = table(honest)
known = table(pack / "reference.csv.gz")
smooth = lambda x: np.convolve(np.pad(x, 1, mode="edge"), [0.25, 0.5, 0.25], "valid")
noisy = dict(zip((P, V, F), between(known["time_s"], [known[P], known[V], known[F]], run["time_s"])))
noise = np.random.default_rng(1).normal(0, 1e-3 * row["force_peak_n"], len(run["time_s"]))
forgeries = {
    "every second row": {name: np.delete(x, np.s_[2:-1:2]) for name, x in run.items()},
    "smoothed": {**run, F: smooth(run[F]), R: smooth(run[R])},
    "forces a row late": {**run, F: np.roll(run[F], 1), R: np.roll(run[R], 1)},
    "the reference with noise": {**run, **noisy, F: noisy[F] + noise, R: np.roll(noisy[F] + noise, 1)},
    "other forces received": {**run, R: 1.001 * run[R]},
    "kN": {**run, F: 1e-3 * run[F], R: 1e-3 * run[R]},
    "sign": {**run, F: -run[F], R: -run[R]},
    "a motion of its own": {**run, P: run[P] + 1e-5 * np.sin(40 * run["time_s"]) ** 2},
}
assert any("class samples is shown" in word for word in replay(pack, honest)), replay(pack, honest)
for forgery, columns in forgeries.items():
    file = folder / "forged.csv"
    with open(file, "w", newline="") as out:
        csv.writer(out).writerows([list(columns)] + [[repr(float(x)) for x in line] for line in zip(*columns.values())])
    try:
        told = f"scored {score(pack, file)['force_error_rms_of_peak']:.3g} of the peak"
    except Refused as why:
        told = f"not scored: {why}"
    try:
        held = replay(pack, file)
        sys.exit(f"{forgery}: replay holds it: {held}")
    except Refused as why:
        print(f"{forgery} ({told}): {why}")
