"""Input and result of a recovery."""

from collections.abc import Sequence
from math import floor, log10

from msgspec import Struct
from msgspec.structs import replace

from beamcam.errors import Diagnostic, Source
from beamcam.model.part import Part, Profile

DECIMALS = 9  #: beyond which a figure is the noise of arithmetic


class KnownStock(Struct, frozen=True):
    """Known data of a program's bar or sheet."""

    profile: Profile | None = None
    grade: str = ""
    has_thickness: bool = False  #: whether the machine has the thickness of this very sheet


class Recovered(Struct, frozen=True):
    """The parts that a program makes, and remarks."""

    parts: tuple[Part, ...]
    diagnostics: tuple[Diagnostic, ...]
    marked: bool = False  #: whether they have the marks of the program's head


def plain(value: float, slack: float, decimals: int) -> float:
    """The figure with the fewest decimals that a value may stand for, known to within `slack`.

    Drawings have round figures, and sums of rounded ones are off by a little. A figure is taken
    only where it is unlikely to lie so near by chance: its last place is 20 times the slack.
    """
    coarsest = DECIMALS if slack <= 0.0 else floor(-log10(20 * slack) + 1e-9)
    for places in range(min(coarsest, DECIMALS) + 1):
        near = round(value, places)
        if abs(near - value) <= slack:
            return near + 0.0
    return round(value, decimals) + 0.0


def mark_of(name: str) -> str:
    """The mark of a part whose program does not say it: the name of its file."""
    return name.rpartition("/")[2].partition(".")[0] or "part"


def with_marks(parts: Sequence[Part], mark: str) -> tuple[Part, ...]:
    """The parts, those that are alike as one with their number; several are counted."""
    alike: dict[object, list[Part]] = {}
    nowhere = Source("")
    for part in parts:  # but for their places in the program
        features = tuple(replace(f, source=nowhere) for f in part.features)
        alike.setdefault(replace(part, source=nowhere, features=features), []).append(part)
    several = len(alike) > 1
    return tuple(
        replace(same[0], mark=f"{mark}-{k}" if several else mark, quantity=len(same))
        for k, same in enumerate(alike.values(), 1)
    )
