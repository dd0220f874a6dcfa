"""Steel members and drawings in, verified machine programs out.

From Python: `beamcam.read`, `load`, `plan`, `post`, `verify`, `convert`, `simulate`, `diff`,
`recover`, `rest`, `plot`, `report`, `lists` and `labels`, which are the functions of
`beamcam.api`, imported when they are first asked for.
"""

# ruff: noqa: F403, F405  the names of the one star stand in `__all__`

from __future__ import annotations

from importlib import import_module

from beamcam.version import __version__

TYPE_CHECKING = False  # as `typing` has it, which is not loaded before Ctrl-C is seen to
if TYPE_CHECKING:
    from typing import Any

    from beamcam.api import *

__all__ = [
    "__version__", "convert", "diff", "labels", "lists", "load", "plan", "plot", "post", "read",
    "recover", "report", "rest", "simulate", "verify",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    if name in __all__:
        return getattr(import_module("beamcam.api"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
