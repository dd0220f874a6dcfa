"""The picture of a line: its stations along X seen from above, and a section at its spindles.

All of it comes from the machine file. X is where the front of the bar stands, so that a station
is drawn at the X of what it does at the front: `saw.x` and `drill.x`.
"""

from collections.abc import Iterator

from beamcam.machine.machine import Machine
from beamcam.model.description import FACE_NAMES
from beamcam.model.part import Profile
from beamcam.pictures.features import section_outlines
from beamcam.pictures.scene import (
    Circle,
    PaperFrame,
    Point,
    Polyline,
    Scene,
    Shape,
    Text,
    arrow,
    shown,
)
from beamcam.planning.held_up import FROM_EDGE, HeldUp, held_up

WIDTH, HEIGHT = 960.0, 790.0
_LEFT, _RIGHT = 70.0, 890.0  #: of the line on the paper
_AXIS_Y, _BAR_Y = 200.0, 135.0  #: of the axis, and of the bar's middle
_BAR_WIDE = 56.0
_SECTION = (440.0, 545.0)  #: the middle of the section on the paper
_SECTION_SIZE = 210.0
_AWAY = 92.0  #: from the section to a spindle, pixels


def line_scene(machine: Machine) -> Scene:
    """A line in plan and in section; the section is that which `machines check` holds up."""
    held = held_up(machine)
    drawn: list[Shape] = [
        Text("heading", (24.0, 30.0), f"{machine.name}: {machine.title}", 16.0),
        Text("heading", (24.0, 62.0), "from above, the bar comes from the left", 12.0),
        *_plan(machine),
    ]
    if held:
        drawn += _section(held)
    about = "where saw and drills stand along X, and how the axes of each spindle count"
    return Scene(f"line {machine.name}", about, WIDTH, HEIGHT, tuple(drawn))


def _plan(machine: Machine) -> Iterator[Shape]:
    """The stations at their X, a bar whose front stands past them, and the signs of the saw."""
    stations: list[tuple[float, str, str]] = []  #: X, class and name, upstream first
    if machine.saw is not None:
        stations.append((machine.saw.x, "cut", "saw"))
    if machine.drill is not None:
        stations.append((machine.drill.x, "tool-0", "drills"))
    stations.sort()
    first, last = stations[0][0], stations[-1][0]
    room = max(last - first, 400.0)
    low, front = first - 0.8 * room, last + 0.45 * room
    frame = PaperFrame((_RIGHT - _LEFT) / (last + 0.75 * room - low), 0.0, _AXIS_Y)
    frame = PaperFrame(frame.scale, _LEFT - low * frame.scale, _AXIS_Y)
    a, b = frame.at(low, 0.0)[0], frame.at(front, 0.0)[0]
    top, bottom = _BAR_Y - _BAR_WIDE / 2, _BAR_Y + _BAR_WIDE / 2
    yield Polyline("part", ((a, top), (b, top), (b, bottom), (a, bottom)), True, "the bar")
    yield Text("figure", ((a + b) / 2, _BAR_Y + 4.0), "bar; x counts back from its front", 10.0,
               "middle")  # fmt: skip
    yield Polyline("stop", ((b, top - 14.0), (b, _AXIS_Y)))
    yield Text("label", (b + 6.0, top - 4.0), f"front of the bar: here at X {shown(front)}", 10.0)
    yield arrow((_LEFT, _AXIS_Y), (_RIGHT, _AXIS_Y))
    yield Text("figure", (_RIGHT + 6.0, _AXIS_Y + 4.0), "X", 12.0)
    for x, classes, name in stations:
        at = frame.at(x, 0.0)[0]
        yield Polyline(f"{classes} station", ((at, top - 26.0), (at, _AXIS_Y + 6.0)), False, name)
        yield Text("heading", (at + 4.0, top - 16.0), name, 12.0)
        yield Text("figure", (at, _AXIS_Y + 20.0), f"X {x:g}", 10.0, "middle")
    for row, text in enumerate(_saw_texts(machine)):
        yield Text("figure", (_LEFT, _AXIS_Y + 42.0 + 15.0 * row), text, 10.0)


def _saw_texts(machine: Machine) -> Iterator[str]:
    """The signs and ranges of a saw, in words."""
    saw = machine.saw
    if saw is None:
        yield "no saw: parts come in cut to length"
        return
    yield (
        f"saw: kerf {saw.kerf:g}, X counted on the edge {saw.pivot} of the web, a square cut is "
        f"called {saw.zero_angle:g}"
    )
    sign = "grows with" if saw.angle_sign > 0 else "falls with"
    yield (
        f"its angle from {saw.min_angle:g} to {saw.max_angle:g} degrees {sign} DSTV's web angle "
        "(positive: x falls from the bottom edge to the top edge)"
    )
    if saw.min_tilt or saw.max_tilt:
        sign = "grows with" if saw.tilt_sign > 0 else "falls with"
        yield f"its tilt from {saw.min_tilt:g} to {saw.max_tilt:g} degrees {sign} the flange angle"


def _section(held: tuple[HeldUp, ...]) -> Iterator[Shape]:
    """The section seen along the bar from its front, each spindle at the hole held up to it."""
    profile = held[0].profile
    scale = _SECTION_SIZE / max(profile.height, profile.width)
    frame = PaperFrame(
        scale, _SECTION[0] - profile.width * scale / 2, _SECTION[1] + profile.height * scale / 2
    )
    yield Text("heading", (24.0, 300.0),
               f"section {profile.name} from the start, v to the right; a hole "
               f"{shown(FROM_EDGE)} mm from the edge at each spindle", 12.0)  # fmt: skip
    for outline in section_outlines(profile):
        yield Polyline("section", frame.all(outline), True)
    for one in held:
        yield from _spindle(one, profile, frame)


#: Of each face the way out of the steel, and the way along its y, as (z, y) of the section.
_OUT = {"v": (1.0, 0.0), "h": (-1.0, 0.0), "o": (0.0, 1.0), "u": (0.0, -1.0)}
_ALONG = {"v": (0.0, 1.0), "h": (0.0, 1.0), "o": (1.0, 0.0), "u": (1.0, 0.0)}


def hole_at(one: HeldUp, profile: Profile) -> Point:
    """(z, y) of the section where the hole meets its face."""
    face, front = one.spindle.face, profile.face_depth(one.spindle.face)
    return {
        "v": (profile.width - front, one.y), "h": (front, one.y),
        "o": (one.y, profile.height - front), "u": (one.y, front),
    }[face]  # fmt: skip


def _spindle(one: HeldUp, profile: Profile, frame: PaperFrame) -> Iterator[Shape]:
    """A spindle as an arrow to its hole, with its places and the ways in which its axes grow."""
    spindle, (oz, oy), (az, ay) = one.spindle, _OUT[one.spindle.face], _ALONG[one.spindle.face]
    z, y = hole_at(one, profile)
    x0, y0 = frame.at(z, y)
    tail = x0 + oz * (_AWAY + profile.face_depth(spindle.face) * frame.scale), y0 - oy * _AWAY
    yield arrow(tail, (x0, y0), f"tool-0 spindle-{spindle.face}")
    yield Circle(f"hole held-{spindle.face}", (x0, y0), 4.0, one.sentence)
    way = one.across_way
    ends = [(tail[0] + k * az * 34.0, tail[1] - k * ay * 34.0) for k in (-way, way)]
    yield arrow(ends[0], ends[1])
    grows = "into" if one.stroke_way > 0 else "out of"
    lines = (
        f"{spindle.name}, spindle {spindle.number}: {FACE_NAMES[spindle.face]} {spindle.face}",
        f"{spindle.across.axis} {shown(one.across)} (grows along the arrow)",
        f"{spindle.stroke.axis} {shown(one.enters)} to {shown(one.leaves)} (grows {grows} the "
        "steel)",
        f"y {shown(one.y)} of {shown(profile.face_width(spindle.face))}",
    )
    left = tail[0] + 46.0 if oz >= 0 else tail[0] - 46.0
    top = tail[1] - 20.0
    for row, text in enumerate(lines):
        yield Text("heading" if row == 0 else "figure", (left, top + 15.0 * row), text, 10.0,
                   "start" if oz >= 0 else "end")  # fmt: skip
    yield Text("figure", (ends[1][0] + 5.0, ends[1][1] - 5.0), f"{spindle.across.axis}+", 10.0)
