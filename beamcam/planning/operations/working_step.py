"""Work at a place of a part, by a spindle or by what letters; other outcomes of a feature."""

from typing import Literal

from msgspec import Struct

from beamcam.errors import Diagnostic, Source
from beamcam.geometry.plane import Point
from beamcam.model.plan import Typed
from beamcam.planning.operations.tools import Tooling


class WorkingStep(Struct, frozen=True):
    """One operation of a spindle, at its place on the part (the workingstep of ISO 14649)."""

    x: float
    y: float
    tooling: Tooling
    features: tuple[int, ...]  #: those of the part that it makes
    source: Source
    path: tuple[Point, ...] = ()  #: x on the part and y on the face; () for a stroke
    text: Typed | None = None  #: that a stamp or printer is told


class Settled(Struct, frozen=True):
    """A feature that needs no working step of its own."""

    feature: int
    how: Literal["made", "duplicate", "listed"]
    by: str  #: "saw", why it is left for manual work, or the code that says why
    like: int | None = None  #: the feature that it repeats


Said = tuple[int, Diagnostic]  #: a message about a feature, by its index
Found = WorkingStep | Settled | Said
