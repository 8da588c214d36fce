"""Runs the pack's three masters over packs and writes an entry of each: python entries.py PACKS OUT [--replay] [PACK …]

OUT/<entry>/ gets entry.toml and runs/. `rimbench judge OUT/<entry> --problems PACKS` makes its summary.csv. A tool that is not
installed is skipped with a word. With --replay, which takes three times as long, replay.py holds each run that completed, and the
evidence of an entry all of whose runs it holds is `replayed`."""
import datetime, gzip, hashlib, importlib, importlib.metadata, json, multiprocessing, platform, sys
from pathlib import Path

ENTRIES = {
    "FMPy loop, mechanics first": ("fmpy_loop", "fmpy", "own loop over FMI 3.0: mechanics, then actuator with its end", ["mechanics-first"]),
    "FMPy SSP": ("fmpy_ssp", "fmpy", "fmpy.ssp.simulation.simulate_ssp over FMI 2.0, starts and times set right", []),
    "libcosim": ("libcosim", "libcosimpy", "fixed-step algorithm over FMI 2.0, as it comes", []),
}


def run(task):
    module, pack, step, phase, out, more, replayed = task
    sys.path[:0] = [str(Path(pack)), str(Path(pack) / "masters")]
    plain = out.with_suffix("")
    try:
        failed = importlib.import_module(module).run(pack, step, plain, *more, phase=phase)
    except Exception as why:
        failed = f"{type(why).__name__}: {why}"
    told, sha = None, None
    if not failed:
        data = plain.read_bytes()
        out.write_bytes(gzip.compress(data, 6, mtime=0))
        sha = hashlib.sha256(out.read_bytes()).hexdigest()
        told = held(pack, out) if replayed else []
    plain.unlink(missing_ok=True)
    return task, failed, sha, told


def held(pack, file):
    from replay import replay
    from score import Refused, score
    try:
        # What diverges is amplified beyond what two processors agree on.
        return replay(pack, file) if score(pack, file)["outcome"] == "completed" else []
    except Refused as why:
        return [f"refused: {why}"]


def main(packs, out, only, replayed):
    packs = sorted(path.parent for path in Path(packs).glob("*/score.json") if not only or path.parent.name in only)
    for name, (module, package, settings, more) in ENTRIES.items():
        try:
            version = importlib.metadata.version(package)
        except importlib.metadata.PackageNotFoundError:
            print(f"skipped: {name}: {package} is not installed")
            continue
        folder = Path(out) / name.lower().replace(",", "").replace(" ", "-")
        (folder / "runs").mkdir(parents=True, exist_ok=True)
        tasks = []
        for pack in packs:
            rule = json.loads((pack / "score.json").read_text())
            pack_version = rule["version"]
            for step in rule["macro_steps_s"]:
                for k, phase in enumerate(rule["phases"]):
                    tasks.append((module, str(pack), step, phase, folder / f"runs/{pack.name}-{step!r}-{k}.csv.gz", more, replayed))
        with multiprocessing.Pool(2, maxtasksperchild=50) as pool:
            found = pool.map(run, tasks, chunksize=1)
        lines, refused = [], []
        for (_, pack, step, phase, file, *_), failed, sha, told in found:
            row = f'{{ problem = "{Path(pack).name}", macro_step_s = {step!r}, phase = {phase!r}, '
            if failed:
                reason = str(failed).splitlines()[0].replace("\\", "/").replace('"', "'")[:120]
                lines.append(row + f'outcome = "failed", reason = "{reason}" }},')
            else:
                lines.append(row + f'file = "runs/{file.name}", sha256 = "{sha}" }},')
                refused += [f"{file.name}: {word}" for word in told if word.startswith("refused") or "not shown" in word]
        evidence = "replayed" if replayed and not refused else "told"
        print(f"{name}: {len(tasks)} runs, {sum(bool(failed) for _, failed, *_ in found)} broke off, {len(refused)} not held by replay")
        for word in refused[:5]:
            print("   ", word)
        whose = {"fmpy_loop": "a loop of the pack over FMPy", "fmpy_ssp": "the loop of FMPy", "libcosim": "the loop of libcosim"}[module]
        tool = {"fmpy": "FMPy", "libcosimpy": "libcosim (libcosimpy)"}[package]
        (folder / "entry.toml").write_text(
            f'name = "{name}"\nclass = "samples"\ndivision = "closed"\nuses = []\ntool = "{tool}"\nversion = "{version}"\n'
            f'settings = "{settings}"\nauthors = ["{whose}, run by rimbench"]\nof_the_benchmark = false\n'
            f'date = "{datetime.date.today()}"\nlicence = "MIT"\nmachine = "{platform.machine()}-{platform.system().lower()}"\n'
            f'evidence = "{evidence}"\npack_version = "{pack_version}"\nruns = [\n' + "".join(f"    {line}\n" for line in lines) + "]\n")


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], [name for name in sys.argv[3:] if name != "--replay"], "--replay" in sys.argv)
