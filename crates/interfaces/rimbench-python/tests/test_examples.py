"""Every example runs, the notebook among them, and the types are what they say."""

import re
import subprocess
import sys

import pytest
from conftest import EXAMPLES, HERE, ROOT

GUIDE = ROOT / "docs" / "guide" / "mujoco.md"


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.py")), ids=lambda path: path.stem)
def test_an_example_runs(path, tmp_path):
    done = subprocess.run([sys.executable, path], cwd=tmp_path, capture_output=True, text=True, check=False)
    if "skipped: " in done.stdout:
        pytest.skip(done.stdout.strip())
    assert done.returncode == 0, done.stderr
    assert "completed" in done.stdout
    if path.stem == "excavator":
        # With valves closed the bucket stays where it is by 1 mm in 10 s, and sinks by a hold.
        teeth = {line.split()[0]: float(line.split("teeth ")[1].split()[0]) for line in done.stdout.splitlines()}
        assert abs(teeth["rim-nonsmooth-gap"]) < 1.0 and abs(teeth["rim-answers"]) < 1.0
        assert teeth["zero-order-hold"] < -50.0
        # What the guide's table says, to its digits.
        rows = re.findall(r"^\| \[([\w-]+)\].*\| (sink|rise) ([\d.]+) mm \|$", GUIDE.read_text(encoding="utf-8"), re.M)
        assert len(rows) == len(teeth) == 3
        for scheme, way, mm in rows:
            assert teeth[scheme] == pytest.approx(float(mm) * (-1.0 if way == "sink" else 1.0), rel=0.05)


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.ipynb")), ids=lambda path: path.stem)
def test_a_notebook_runs_and_is_kept_without_what_it_printed(path, tmp_path):
    nbclient, nbformat = pytest.importorskip("nbclient"), pytest.importorskip("nbformat")
    pytest.importorskip("ipykernel")
    pytest.importorskip("matplotlib")
    notebook = nbformat.read(path, as_version=4)
    for cell in notebook.cells:
        if cell.cell_type == "code":
            assert cell.outputs == [] and cell.execution_count is None
    nbclient.NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(tmp_path)}}).execute()
    drawn = [output for cell in notebook.cells for output in cell.get("outputs", []) if "image/png" in output.get("data", {})]
    assert drawn


def test_the_programs_of_the_guide_run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = (ROOT / "docs" / "guide" / "python.md").read_text(encoding="utf-8")
    blocks = [part.split("```")[0] for part in text.split("```python\n")[1:]]
    assert len(blocks) >= 5
    names = {"__name__": "guide"}
    for block in blocks:
        exec(compile(block, "python.md", "exec"), names)
    assert names["run"].completed and names["found"].stability_limit_s is not None


def test_the_moving_picture_of_the_servos_shows_what_its_script_finds(tmp_path):
    pytest.importorskip("mujoco")
    drawn, servos = tmp_path / "quadruped.svg", ROOT / "experiments/study/servos"
    subprocess.run([sys.executable, servos / "moving.py", drawn], cwd=tmp_path, capture_output=True, check=True)
    words = [re.findall("<text.*?>(.*?)<", path.read_text(encoding="utf-8")) for path in (drawn, ROOT / "docs/results/quadruped.svg")]
    assert words[0] == words[1] and [":" in word for word in words[0]] == [True] * 3


def test_the_package_says_its_types():
    pytest.importorskip("mypy")
    from mypy import api

    package = HERE.parent / "python" / "rimbench"
    said, complained, status = api.run(["--strict", "--ignore-missing-imports", str(package)])
    assert status == 0, said + complained


#: What users write; each line that ends in `# wrong` must be refused.
SNIPPET = """
from collections.abc import Sequence

import rimbench


class Mass:
    def __init__(self, parameters: dict[str, float]) -> None:
        self.x = parameters["x2_0_m"]

    def outputs(self, u: tuple[float, ...]) -> Sequence[float]:
        return self.x, 0.0

    def step(self, t: float, u: tuple[float, ...], h: float) -> None:
        self.x += h * u[0]


case = rimbench.Case("mine", like="linear-oscillator", mechanics=Mass, reference="original")
name: str = case.name.upper()
suffix = case.name.suffix  # wrong
result = rimbench.simulate(case, "zero-order-hold", 1e-3, duration_s=0.1)
largest: float = result["x2_m"].max()
error: float = result.metrics["position_error_rms_m"]  # wrong


class Hold:
    def __init__(self, outputs: dict[str, tuple[str, ...]]) -> None:
        self.held: dict[str, tuple[float, ...]] = {}

    def receive(self, side: str, sample: rimbench.Sample) -> None:
        self.held[side] = sample.y

    def input(self, side: str, at: rimbench.MicroStep, own: tuple[float, ...]) -> tuple[float, ...]:
        return self.held[side]


scheme = rimbench.Scheme("hold", Hold)
print(scheme.name.split("-"), rimbench.limit(case, scheme, per_decade=3).stability_limit_s)
rimbench.Scheme("none", Mass)  # wrong
rimbench.simulate(scheme, case)  # wrong
"""


def test_what_users_write_has_the_types_that_they_see(tmp_path):
    pytest.importorskip("mypy")
    from mypy import api

    (tmp_path / "snippet.py").write_text(SNIPPET)
    said, complained, _ = api.run(["--strict", "--cache-dir", str(tmp_path), str(tmp_path / "snippet.py")])
    refused = {int(line.split(":")[1]) for line in said.splitlines() if "snippet.py:" in line and " error: " in line}
    wrong = {number for number, line in enumerate(SNIPPET.splitlines(), 1) if line.endswith("# wrong")}
    assert refused == wrong, said + complained


def test_the_stub_has_everything_that_the_module_has():
    import ast

    from rimbench import _native

    stub = ast.parse((HERE.parent / "python" / "rimbench" / "_native.pyi").read_text())
    named = {node.name for node in stub.body if isinstance(node, (ast.ClassDef, ast.FunctionDef))}
    there = {name for name in dir(_native) if not name.startswith("_")}
    assert there <= named
    for node in stub.body:
        if isinstance(node, ast.ClassDef) and node.name in there:
            kind = getattr(_native, node.name)
            members = {item.name for item in node.body if isinstance(item, ast.FunctionDef)} - {"__init__", "__new__"}
            assert members == {name for name in vars(kind) if not name.startswith("_")} or node.name == "RimbenchError"
