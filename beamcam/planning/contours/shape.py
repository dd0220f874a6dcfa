"""A contour that one process follows."""

from msgspec import Struct

from beamcam.errors import Source
from beamcam.geometry.curves import Curve
from beamcam.machine.torch import TorchProcess


class Shape(Struct, frozen=True, gc=False):
    """A contour that one process follows, and where it lies among the cut ones.

    The part is the set of points that an odd number of closed cut contours enclose, contours
    that are drawn twice counted once. So a contour of even depth is an outline, whose waste lies
    outside of it, and one of odd depth a hole, whose waste lies inside.
    """

    process: TorchProcess
    curves: tuple[Curve, ...]
    closed: bool
    features: tuple[int, ...]  #: ascending; `assign_process.OUTLINE` may be among them
    source: Source
    depth: int = 0  #: nesting depth: number of cut contours around it
    parent: int = -1  #: the innermost of them, by its index; -1 for none
    look: str = ""  #: key of the settings that it is worked with
    level: int = 0  #: of common cuts: after those of lower levels, on which it begins and ends
    is_begun: bool = False  #: whether it has to begin where it does
    is_small: bool = False  #: a small hole, by the row that it is cut with
    area: float = 0.0  #: inside of a closed cut, mm2, above 0 if it runs counter-clockwise

    @property
    def is_ring(self) -> bool:
        """Whether it has an inside, as an offset needs one."""
        return self.closed and self.area != 0.0

    @property
    def is_hole(self) -> bool:
        return self.depth % 2 == 1


def entity(source: Source) -> str:
    """Name of another entity of the same file in messages: its handle, line or element."""
    if source.where is not None:
        return source.where
    return f"line {source.line}" if source.line is not None else source.file
