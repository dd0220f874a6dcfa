"""The ends of a bar's part as they are seen on its faces: lines, cuts, and their angles."""

from collections.abc import Iterator
from math import atan2, degrees, radians, tan

from beamcam.model.part import EndPlane, Face, Part, Profile
from beamcam.model.section import FACE_NAMES
from beamcam.pictures.callouts import Place, Size
from beamcam.pictures.scene import Frame, Point, Polyline


def _rise_and_depth(profile: Profile, face: Face, y: float) -> Point:
    """Place in the section of a point of a face: up from the lower edge, and across."""
    if face in ("v", "h"):
        return y, profile.width / 2
    if profile.code == "T":  # the stem, in the middle of the flange
        return profile.height / 2, y
    return (profile.height if face == "o" else 0.0), y


def end_lines(part: Part, face: Face) -> tuple[tuple[Point, Point], tuple[Point, Point]]:
    """The lines in which the end cuts meet a face, each from y 0 upwards.

    x = c - rise tan(web) - across tan(flange) at both ends; the start touches x 0, the end the
    length (DSTV, header).
    """
    p, cuts = part.profile, part.cuts
    corners = [(r, z) for r in (0.0, p.height) for z in (0.0, p.width)]

    def line(web_deg: float, flange_deg: float, start: bool) -> tuple[Point, Point]:
        a, b = tan(radians(web_deg)), tan(radians(flange_deg))
        ways = [-r * a - z * b for r, z in corners]
        c = -min(ways) if start else part.length - max(ways)

        def at(y: float) -> Point:
            r, z = _rise_and_depth(p, face, y)
            return c - r * a - z * b, y

        return at(0.0), at(p.face_width(face))

    return (
        line(cuts.web_start, cuts.flange_start, True),
        line(cuts.web_end, cuts.flange_end, False),
    )


def end_cuts(part: Part, frame: Frame) -> Iterator[Polyline]:
    """The cuts of both ends, on the web."""
    c = part.cuts
    for k, (line, web, flange) in enumerate(
        zip(end_lines(part, "v"), (c.web_start, c.web_end), (c.flange_start, c.flange_end),
            strict=True)
    ):  # fmt: skip
        angles = f"web {web:g}, flange {flange:g} degrees"
        yield Polyline("cut", frame.all(line), False, f"{'end' if k else 'start'} cut, {angles}")


def cutting_planes(part: Part, frame: Frame) -> Iterator[Polyline]:
    """The cutting planes, where they cross the web at the depth of their point."""
    for plane in part.features:
        if isinstance(plane, EndPlane) and plane.normal[0]:
            (px, py, _), (nx, ny, nz) = plane.point, plane.normal
            line = [(px - (y - py) * ny / nx, y) for y in (0.0, part.profile.height)]
            tip = f"cutting plane, normal {nx:g}, {ny:g}, {nz:g}"
            yield Polyline("cut", frame.all(line), False, tip)


def mitres(part: Part, face: Face) -> Iterator[Size]:
    """The angles of skew end cuts as they are seen on a face, and of cutting planes on the web."""
    if face not in FACE_NAMES or part.measures is not None:
        return
    c, on_web = part.cuts, face in ("v", "h")
    angles = (c.web_start, c.web_end) if on_web else (c.flange_start, c.flange_end)
    if part.profile.code != "B":
        for (a, b), angle in zip(end_lines(part, face), angles, strict=True):
            if angle:
                middle = Place(((a[0] + b[0]) / 2, (a[1] + b[1]) / 2))
                yield Size((f"mitre {round(abs(angle), 2):g}\N{DEGREE SIGN}",), (middle,), False)
    for plane in part.features if face == "v" else ():
        if isinstance(plane, EndPlane) and plane.normal[0]:
            (px, py, _), (nx, ny, nz) = plane.point, plane.normal
            web, tilt = (round(degrees(atan2(n, abs(nx))), 2) for n in (ny, nz))
            tilted = f", tilted {abs(tilt):g}\N{DEGREE SIGN}" if tilt else ""
            words = f"plane {abs(web):g}\N{DEGREE SIGN}{tilted}"
            yield Size((words,), (Place((px, py)),), False)
