"""What the tests share: a cache of references of their own, the examples, and the program, where there is one."""

import importlib.util
import os
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent
ROOT = HERE.parents[3]
EXAMPLES = HERE.parent / "examples"


@pytest.fixture(autouse=True, scope="session")
def own_cache(tmp_path_factory):
    if "RIMBENCH_CACHE" not in os.environ:
        os.environ["RIMBENCH_CACHE"] = str(tmp_path_factory.mktemp("cache"))


@pytest.fixture(scope="session")
def program():
    """The command line, built from the same sources."""
    path = os.environ.get("RIMBENCH_PROGRAM")
    if not path:
        pytest.skip("RIMBENCH_PROGRAM does not say where the program is")
    return path


@pytest.fixture
def example():
    def load(name):
        spec = importlib.util.spec_from_file_location(name, EXAMPLES / f"{name}.py")
        module = importlib.util.module_from_spec(spec)
        sys.modules[name] = module
        spec.loader.exec_module(module)
        return module

    return load
