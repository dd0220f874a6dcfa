"""Steel members and drawings in, verified machine programs out.

From Python: `beamcam.read`, `load`, `plan`, `post`, `verify`, `convert`, `simulate`, `diff`,
`recover`, `rest`, `plot`, `report`, `lists` and `labels`, which are the functions of
`beamcam.api`, imported when they are first asked for.
"""

from __future__ import annotations

import sys
from importlib import import_module
from types import ModuleType

from beamcam.version import __version__

TYPE_CHECKING = False  # as `typing` has it, which is not loaded before Ctrl-C is seen to
if TYPE_CHECKING:
    from typing import Any

    from beamcam.api import (
        convert,
        diff,
        labels,
        lists,
        load,
        plan,
        plot,
        post,
        read,
        recover,
        report,
        rest,
        simulate,
        verify,
    )

__all__ = [
    "__version__", "convert", "diff", "labels", "lists", "load", "plan", "plot", "post", "read",
    "recover", "report", "rest", "simulate", "verify",
]  # fmt: skip


#: Names of functions that are those of sub-packages too.
_BOTH = ("diff", "report", "simulate", "verify")


class _Function(ModuleType):
    """A sub-package, such as `beamcam.verify`, which can be called as the function of its name."""

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        functions = import_module("beamcam.api")
        return getattr(functions, self.__name__.rpartition(".")[2])(*args, **kwargs)


class _Package(ModuleType):
    """This package. An import of its sub-package `verify` binds that to the name of the function;
    so that either is meant rightly, whichever comes first, the sub-package is made callable."""

    def __setattr__(self, name: str, value: object) -> None:
        if name in _BOTH and isinstance(value, ModuleType):
            value.__class__ = _Function
        super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package


def __getattr__(name: str) -> Any:
    if name in __all__:
        if name in _BOTH:
            return import_module(f"beamcam.{name}")
        return getattr(import_module("beamcam.api"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
