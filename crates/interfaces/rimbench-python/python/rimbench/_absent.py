"""Stands for the compiled part where that cannot be loaded: `rimbench.servo` needs none of it, and anything else says why it fails."""

from __future__ import annotations

import sys
from types import ModuleType
from typing import Any


class Absent(ModuleType):
    """A module in which every name is a class that cannot be made."""

    reason: ImportError
    __version__ = "unknown"

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)

        def refuse(*_: object, **__: object) -> None:
            text = f"`{name}` needs the compiled part of rimbench, which cannot be loaded ({self.reason}); valid: pip install the wheel"
            raise ImportError(text) from self.reason

        self.__dict__[name] = type(name, (Exception,) if name == "RimbenchError" else (), {"__new__": refuse})
        return self.__dict__[name]


def stand_in(reason: ImportError) -> None:
    """Makes `rimbench._native` such a module."""
    module = Absent("rimbench._native")
    module.reason = reason
    sys.modules[module.__name__] = module
