"""Spindle positions for an operation, by the machine's formulas."""

from msgspec import Struct

from beamcam.machine.machine import Machine, drill_of
from beamcam.machine.stations import Axis, Drill, Spindle
from beamcam.model.part import Face, Profile
from beamcam.model.plan import SpindleOp

Place = tuple[float, float]  #: Y and Z of the machine


class Stroke(Struct, frozen=True):
    """One stroke in machine coordinates, along the axis that drives the spindle in."""

    across: float  #: place of the axis across the bar
    start: float  #: free of the section
    near: float  #: where the rapid approach ends
    bottom: float


class Strokes:
    """The strokes of a machine's spindles on one section."""

    def __init__(self, profile: Profile, machine: Machine) -> None:
        self._drill = drill = drill_of(machine)
        self.spindles: dict[Face, Spindle] = {s.face: s for s in machine.spindles}
        self._values = {face: formula_values(profile, face, drill) for face in self.spindles}

    def axes(self, op: SpindleOp) -> tuple[Axis, Axis]:
        """The axis across the bar and the one that strokes."""
        spindle = self.spindles[op.faces[0]]
        return spindle.across.axis, spindle.stroke.axis

    def __call__(self, op: SpindleOp, y: float) -> Stroke:
        """The stroke of an operation at `y` on its face.

        The depth of a drill counts to its full diameter, and the tip goes beyond; the depth of
        other tools is that of their point. Through goes beyond the far side by the breakthrough.
        """
        face = op.faces[0]
        across, stroke = self.spindles[face].across, self.spindles[face].stroke
        values = dict(self._values[face])
        values["y"] = y
        through = values["thickness"] + self._drill.breakthrough
        values["depth"] = through if op.depth is None else op.depth
        values["tip"] = op.tool.tip if op.tool.kind == "drill" else 0.0
        start = stroke.start(values)
        return Stroke(
            across.position(values),
            start,
            start if stroke.near is None else stroke.near(values),
            stroke.bottom(values),
        )

    def places(self, op: SpindleOp, y: float) -> tuple[Place, Place, Place]:
        """Y and Z of an operation's stroke: free of the section, near, and at the bottom."""
        stroke, axes = self(op, y), self.axes(op)
        return (
            _yz(axes, stroke.across, stroke.start),
            _yz(axes, stroke.across, stroke.near),
            _yz(axes, stroke.across, stroke.bottom),
        )


def _yz(axes: tuple[Axis, Axis], across: float, along: float) -> Place:
    at = {axes[0]: across, axes[1]: along}
    return at["Y"], at["Z"]


def formula_values(profile: Profile, face: Face, drill: Drill) -> dict[str, float]:
    """The names that a machine's formulas may use, as far as the section gives them."""
    return {
        "height": profile.height,
        "width": profile.width,
        "flange_thickness": profile.flange_thickness,
        "web_thickness": profile.web_thickness or 0.0,
        "thickness": profile.thickness(face),
        "face_depth": profile.face_depth(face),
        "clearance": drill.clearance,
    }
