"""The plan: which tool makes which feature, where along the machine, in which order."""

from dataclasses import dataclass
from typing import Literal

from beamcam.errors import Diagnostic, Source
from beamcam.machine.machine import Tool
from beamcam.model.part import Face, Part, Profile

FeatureRef = tuple[int, int]  #: index of the piece on the bar, index of its feature


@dataclass(frozen=True, slots=True)
class Piece:
    """One part laid on the bar."""

    part: Part
    start: float  #: bar x of the part's x 0

    @property
    def end(self) -> float:
        return self.start + self.part.length


@dataclass(frozen=True, slots=True)
class Bar:
    """The account of a bar: its stretches add up to its length."""

    length: float
    front_trim: float
    parts: float
    kerfs: float
    rest: float  #: what is left over behind the last cut


@dataclass(frozen=True, slots=True)
class SawOp:
    """One cut through the bar."""

    x: float  #: machine X, of the blade's middle on the pivot edge
    angle: float  #: degrees in the machine's own counting
    purpose: Literal["trim", "mitre", "parting"]
    pieces: tuple[int, ...]  #: those that get an end by it
    source: Source


@dataclass(frozen=True, slots=True)
class DrillOp:
    """One stroke of a spindle, or of two at once."""

    x: float  #: machine X
    spindle: int  #: what the program calls the spindle, or the pair of them
    tool: Tool
    faces: tuple[Face, ...]
    y: float  #: on the face
    depth: float | None  #: None is through
    features: tuple[FeatureRef, ...]
    reason: str  #: why this tool, why merged
    source: Source


Operation = SawOp | DrillOp


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of one feature."""

    feature: FeatureRef
    how: Literal["made", "merged", "skipped"]
    by: str  #: the operation that makes it, or the code that it was skipped by


@dataclass(frozen=True, slots=True)
class Plan:
    """The work of one bar, in order."""

    profile: Profile
    pieces: tuple[Piece, ...]
    bar: Bar
    operations: tuple[Operation, ...]
    outcomes: tuple[Outcome, ...]  #: one for every feature of every piece
    remarks: tuple[Diagnostic, ...] = ()
