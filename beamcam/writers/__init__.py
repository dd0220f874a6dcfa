from collections.abc import Callable
from importlib import import_module

from msgspec import Struct

from beamcam.model.part import Part


class Target(Struct, frozen=True):
    """A format that a part can be written in."""

    name: str
    suffixes: tuple[str, ...]
    module: str  #: its `write` turns a part into the file's content

    @property
    def write(self) -> Callable[[Part], str]:
        function: Callable[[Part], str] = import_module(self.module).write
        return function


TARGETS = (
    Target("dstv", (".nc1", ".nc"), "beamcam.writers.dstv"),
    Target("part-json", (".json",), "beamcam.model.part_json"),
    Target("faces-dxf", (".dxf",), "beamcam.writers.faces_dxf"),
)


def target_of_suffix(suffix: str) -> Target:
    """The format that is written under a suffix, such as `.nc1`."""
    return next(target for target in TARGETS if suffix in target.suffixes)
