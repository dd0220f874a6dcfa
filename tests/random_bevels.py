"""Random parts for a coper that tilts: bevels up to the surface, of cut-outs, along curves."""

from itertools import pairwise
from math import asin, cos, degrees, pi, radians, sin
from random import Random

from msgspec.structs import replace

from beamcam.geometry.curves import Arc, BSpline, Curve, EllipseArc, Line
from beamcam.geometry.plane import Point
from beamcam.model.part import Bevel, Contour, Part
from tests.random_copes import AT, SECTIONS, polygon

ENDS = ("line", "slanted", "arc", "facets", "spline", "ellipse")
WINDOWS = ("circle", "window", "ellipse", "facets")


def random_cut_out(seed: int) -> Part:
    """A part with a cut-out in its web, on v or h, bevelled all round on either side."""
    random = Random(seed)
    profile = random.choice([one for one in SECTIONS if one.height > 140.0])
    length = round(random.uniform(500.0, 900.0), 1)
    low = profile.flange_thickness + profile.radius
    high = profile.height - (low if profile.code in "IU" else 0.0)
    x, y = round(length / 2, 1), round((low + high) / 2, 1)
    most = (high - low) / 2 - 20.0
    tall, wide = round(random.uniform(0.4, 0.8) * most, 1), round(random.uniform(30.0, 90.0), 1)
    curves = _window(random.choice(WINDOWS), (x, y), max(tall, 20.0), wide, random)
    web = profile.web_thickness or 0.0
    angle, land = round(random.uniform(25.0, 44.0), 1), round(random.uniform(0.0, 0.3) * web, 1)
    face = random.choice("vvh")
    kind = random.choice(("near", "whole", "whole", "land"))
    one = {"near": (angle, land), "whole": (-angle, 0.0), "land": (-angle, round(web / 2, 2))}[kind]
    if face == "h":
        one = -one[0], round(web - (one[1] or web * (one[0] < 0.0)), 2)
    bevels = tuple(Bevel(k, *one) for k in range(len(curves)))
    window = Contour(face, "inner", tuple(curves), AT, bevels=bevels)  # type: ignore[arg-type]
    return Part(f"O{seed}", profile, length, AT, features=(window,), grade="S235JR")


def _window(kind: str, at: Point, tall: float, wide: float, random: Random) -> list[Curve]:
    """A closed chain round a place, half as wide and tall as given; counter-clockwise."""
    x, y = at
    if kind == "circle":
        return [Arc(at, tall, 0.0, 180.0), Arc(at, tall, 180.0, 180.0)]
    if kind == "window":
        r = round(random.uniform(0.4, 0.9) * min(tall, wide), 1)
        w, t = wide - r, tall - r
        corners = [(x + w, y + t, 0), (x - w, y + t, 90), (x - w, y - t, 180), (x + w, y - t, 270)]
        arcs = [Arc((cx, cy), r, float(first), 90.0) for cx, cy, first in corners]
        return [c for a, b in pairwise((*arcs, arcs[0])) for c in (a, Line(a.end, b.start))]
    if kind == "ellipse":
        major, minor = max(tall, wide), min(tall, wide)
        axis = (wide, 0.0) if wide >= tall else (0.0, tall)
        return [EllipseArc(at, axis, minor / major, 0.0, 360.0)]
    count, wide = random.randint(32, 48), min(wide, 1.5 * tall)  # no corner of 20 degrees
    tall = min(tall, 1.5 * wide)
    turns = [2 * pi * k / count for k in range(count)]
    return [*polygon([(x + wide * cos(t), y + tall * sin(t)) for t in turns])]


def random_end(seed: int) -> Part:
    """A part whose web stands out between its flanges, its end straight or any curve, with one
    bevel through all of the wall, or another one; perhaps at both ends."""
    random = Random(seed)
    profile = random.choice([one for one in SECTIONS if one.code != "L"])
    high, web = profile.height, profile.web_thickness or 0.0
    length = round(random.uniform(600.0, 900.0), 1)
    deep = round(profile.flange_thickness + profile.radius + random.uniform(36.0, 45.0), 1)
    back = round(random.uniform(100.0, 120.0), 1)
    at_both = random.random() < 0.4
    end = _end(random.choice(ENDS), length, deep, high - deep, random)
    start = [curve.transformed(((-1, 0, length), (0, -1, high)))
             for curve in _end(random.choice(ENDS), length, deep, high - deep, random)]  # fmt: skip
    first = back if at_both else 0.0
    lower = [(first, 0.0), (length - back, 0.0), (length - back, deep), end[0].start]
    upper = [end[-1].end, (length - back, high - deep), (length - back, high), (first, high)]
    curves = [*_lines(lower), *end, *_lines(upper)]
    begin = len(curves)
    if at_both:
        curves += [*_lines([(first, high), (first, high - deep), start[0].start]), *start,
                   *_lines([start[-1].end, (first, deep), (first, 0.0)])]  # fmt: skip
    else:
        curves.append(Line((0.0, high), (0.0, 0.0)))
    bevels: list[Bevel] = []
    for number, count in ((3, len(end)), (begin + 2, len(start) if at_both else 0)):
        angle = round(random.uniform(20.0, 44.0), 1)
        kind = random.choice(("whole", "whole", "near", "land"))
        land = {"whole": 0.0, "near": 1.0, "land": round(web * 0.4, 2)}[kind]
        angle = angle if kind == "near" else -angle
        bevels += [Bevel(number + k, angle, land) for k in range(count)]
    drawn = Contour("v", "outer", tuple(curves), AT, bevels=tuple(bevels))
    if random.random() < 0.3:
        there = tuple(replace(b, angle=-b.angle, land=round(web - (b.land or (
            web if b.angle < 0.0 else 0.0)), 2)) for b in bevels)  # fmt: skip
        drawn = replace(drawn, face="h", bevels=there)
    flange = polygon([(first, 0.0), (length - back, 0.0), (length - back, profile.width),
                      (first, profile.width)])  # fmt: skip
    flanges = [Contour(face, "outer", flange, AT) for face in "ou"]
    return Part(f"E{seed}", profile, length, AT, features=(drawn, *flanges), grade="S235JR")


def _lines(points: list[Point]) -> list[Curve]:
    return [Line(a, b) for a, b in pairwise(points)]


def _end(kind: str, x: float, low: float, high: float, random: Random) -> list[Curve]:
    """The end of a web from a low place to a high one, no farther than x."""
    by = round(random.uniform(-0.3, 0.3) * (high - low), 2)
    a, b = (x - max(0.0, by), low), (x + min(0.0, by), high)
    if kind == "line":
        return [Line((x, low), (x, high))]
    if kind == "slanted":
        return [Line(a, b)]
    half = (high - low) / 2
    radius = round(half * random.uniform(1.5, 3.0), 1)
    turn = degrees(asin(half / radius))
    bulging = Arc((x - radius, (low + high) / 2), radius, -turn, 2 * turn)
    hollow = Arc((x + radius * cos(radians(turn)), (low + high) / 2), radius, 180.0 + turn,
                 -2 * turn)  # fmt: skip
    arc = random.choice((bulging, hollow))
    if kind == "arc":
        return [arc]
    if kind == "facets":
        count = random.randint(5, 30)
        return _lines([arc.point(k / count) for k in range(count + 1)])
    if kind == "spline":
        off = round(random.uniform(-0.15, 0.15) * half, 2)
        more = abs(off)
        inner = [(x - more + off, low + half / 2), (x - more - off, high - half / 2)]
        ends = [(x - more, low), *inner, (x - more, high)]
        return [BSpline(3, tuple(ends), (0.0,) * 4 + (1.0,) * 4)]
    major, ratio = half / cos(radians(30.0)), round(random.uniform(0.2, 0.6), 3)
    return [EllipseArc((x - ratio * major, (low + high) / 2), (0.0, major), ratio, 210.0, 120.0)]
