"""Every example runs, the notebook among them, and the types are what they say."""

import subprocess
import sys

import pytest
from conftest import EXAMPLES, HERE, ROOT


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.py")), ids=lambda path: path.stem)
def test_an_example_runs(path, tmp_path):
    done = subprocess.run([sys.executable, path], cwd=tmp_path, capture_output=True, text=True, check=False)
    if "skipped: " in done.stdout:
        pytest.skip(done.stdout.strip())
    assert done.returncode == 0, done.stderr
    assert "completed" in done.stdout


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


def test_the_package_says_its_types():
    pytest.importorskip("mypy")
    from mypy import api

    package = HERE.parent / "python" / "rimbench"
    said, complained, status = api.run(["--strict", "--ignore-missing-imports", str(package)])
    assert status == 0, said + complained


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
            members = {item.name for item in node.body if isinstance(item, ast.FunctionDef)} - {"__init__"}
            assert members == {name for name in vars(kind) if not name.startswith("_")} or node.name == "RimbenchError"
