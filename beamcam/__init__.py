"""Steel members and drawings in, verified machine programs out.

From Python: `beamcam.read`, `load`, `plan`, `post`, `verify` and `convert`, which are the
functions of `beamcam.api`, imported when they are first asked for.
"""

from __future__ import annotations

import sys
from importlib import import_module
from types import ModuleType

TYPE_CHECKING = False  # as `typing` has it, which is not loaded before Ctrl-C is seen to
if TYPE_CHECKING:
    from typing import Any

    from beamcam.api import convert, load, plan, post, read, verify

__version__ = "0.1.0"

__all__ = ["__version__", "convert", "load", "plan", "post", "read", "verify"]


class _Verify(ModuleType):
    """The sub-package `beamcam.verify`, which can be called as the function of that name."""

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        from beamcam.api import verify as function

        return function(*args, **kwargs)


class _Package(ModuleType):
    """This package. An import of its sub-package `verify` binds that to the name of the function;
    so that either is meant rightly, whichever comes first, the sub-package is made callable."""

    def __setattr__(self, name: str, value: object) -> None:
        if name == "verify" and isinstance(value, ModuleType):
            value.__class__ = _Verify
        super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package


def __getattr__(name: str) -> Any:
    if name in __all__:
        if name == "verify":
            return import_module("beamcam.verify")
        return getattr(import_module("beamcam.api"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
