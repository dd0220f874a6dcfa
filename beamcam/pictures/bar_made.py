"""What a program makes on a bar, for its pictures: pieces between cuts, and where they end."""

from itertools import pairwise
from typing import Literal

from msgspec import Struct

from beamcam.checks.bars.pieces import CutPlane, planes
from beamcam.checks.bars.stations import MachinedFeatures
from beamcam.machine.machine import Machine
from beamcam.model.part import Face, Profile
from beamcam.pictures.features import SteelDepths

OPEN_END = 120.0  #: of bar that is drawn behind the last cut where its length is not known
LONG_REMNANT = 1.0  #: share of the worked length, above which a remnant is broken off
BROKEN_REMNANT = 0.25  #: share of the worked length that is drawn of such a remnant


class DrawnPiece(Struct, frozen=True):
    """A piece of the bar between two planes, or an end of it (None)."""

    kind: Literal["trim", "part", "remnant"]
    start: CutPlane | None
    end: CutPlane | None
    mark: str = ""


class BarMade(Struct, frozen=True):
    """Features that a program makes on a bar, and other data of the bar."""

    made: MachinedFeatures
    profile: Profile
    machine: Machine
    name: str  #: of the program
    sha256: str
    bar: float | None = None  #: its length
    marks: tuple[str, ...] = ()  #: of the parts in their order along the bar, where they are known

    @property
    def saw_planes(self) -> list[CutPlane]:
        """The cuts in their order along the bar."""
        saw = self.machine.saw
        return planes(self.made.cuts, saw, self.profile) if saw is not None else []

    @property
    def depths(self) -> SteelDepths:
        """How deep its strokes are in the steel."""
        return SteelDepths(self.machine, self.profile, self.made.bores)

    @property
    def end(self) -> float:
        """End of the bar; where its length is not known, a little behind what is worked."""
        return self.worked + OPEN_END if self.bar is None else self.bar

    @property
    def worked(self) -> float:
        """Bar x of the last cut or hole."""
        drill = self.machine.drill
        places = [p.at_pivot for p in self.saw_planes]
        places += [b.x - drill.x for b in self.made.bores] if drill else []
        return max(places, default=0.0)

    @property
    def drawn_end(self) -> float:
        """End of the bar in the picture, where a long remnant is broken off."""
        is_long = self.end - self.worked > LONG_REMNANT * self.worked > 0.0
        return self.worked * (1 + BROKEN_REMNANT) if is_long else self.end

    def face_width(self, face: Face) -> float:
        """Extent of a face across the bar; as far as its holes where the width is not known."""
        bores = [b.y + b.diameter / 2 for b in self.made.bores if b.face == face]
        return self.profile.face_width(face) or max([1.0, *bores])

    def pieces(self) -> list[DrawnPiece]:
        """Trim, parts and remnant, along the bar; kerfs as thick as wedges count as trim."""
        cuts = self.saw_planes
        if not cuts:
            return [DrawnPiece("remnant", None, None)]
        pieces = [DrawnPiece("trim", None, cuts[0])]
        number = 0
        for start, end in pairwise(cuts):
            if self._is_wedge(start, end):
                pieces.append(DrawnPiece("trim", start, end))
                continue
            mark = self.marks[number] if number < len(self.marks) else f"part {number + 1}"
            pieces.append(DrawnPiece("part", start, end, mark))
            number += 1
        return [*pieces, DrawnPiece("remnant", cuts[-1], None)]

    def _is_wedge(self, start: CutPlane, end: CutPlane) -> bool:
        """Whether a piece comes to nothing at a corner: the waste beside a mitre."""
        if not (start.web_deg or start.flange_deg or end.web_deg or end.flange_deg):
            return False
        lengths = [end.along(*at) - start.along(*at) for at in self._corners]
        return min(lengths) <= start.half_kerf + end.half_kerf + 2 * self.machine.format.resolution

    @property
    def _corners(self) -> list[tuple[float, float]]:
        """The corners of the section, as planes count their y."""
        h, w = self.profile.height, self.profile.width
        return [(self._rise(y), z) for y in (0.0, h) for z in (0.0, w)]

    def extent(self, piece: DrawnPiece) -> tuple[float, float]:
        """Bar x of the first and of the last corner of a piece."""
        start, end = 0.0, self.end
        if piece.start is not None:
            start = min(piece.start.along(*at) for at in self._corners) + piece.start.half_kerf
        if piece.end is not None:
            end = max(piece.end.along(*at) for at in self._corners) - piece.end.half_kerf
        return start, end

    def _rise(self, y: float) -> float:
        saw = self.machine.saw
        return y - self.profile.height if saw is not None and saw.pivot == "o" else y

    def x_on(self, plane: CutPlane, face: str, y: float) -> float:
        """Bar x of a cut at a height of a face."""
        if face in ("v", "h"):
            return plane.along(self._rise(y), self.profile.width / 2)
        up = {"o": self.profile.height, "u": 0.0}[face]
        if self.profile.code == "T":  # the stem, in the middle of the flange
            up = self.profile.height / 2
        return plane.along(self._rise(up), y)
