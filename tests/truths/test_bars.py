"""Programs of the beam cell, run by an interpreter of our tests, beside the parts' own files.

Nothing of beamcam reads the programs or the files here. Each part is found on the bar by the two
cuts that give it its ends; then each of its holes has to be there once, and nothing else.
"""

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import cos, radians, tan
from pathlib import Path
from random import Random
from typing import NamedTuple

import pytest
import shapely

from beamcam import readers
from beamcam.machine import load
from beamcam.pipeline import post
from tests.beam_cell import CELLS, CellError, Cut, Section, Stroke, end_x, run, tilt_of
from tests.conftest import GOLDEN, SAMPLES
from tests.random_bars import THREADS, Bar, Feature, random_bar

BREAKTHROUGH = 2.0  #: of a drill's full diameter beyond the wall
SCRIBED = 0.3
ROUNDED = 0.002  #: mm of figures of three decimals that were added up


class Missing(AssertionError):
    """What the program does not make as the part has it."""


# --- the part's file ------------------------------------------------------------------------------


def read_bar(text: str) -> Bar:
    """Header, holes and slots of a DSTV file, by its grammar: blocks, and numbers in columns."""
    lines = [line.rstrip() for line in text.splitlines() if not line.startswith("**")]
    head = lines[1:]
    length = float(head[8].split(",")[0])
    h, b, tf, tw, r = (float(head[k]) for k in range(9, 14))
    ends = tuple(float(head[k]) for k in range(16, 20))
    features, block = [], ""
    for line in lines[25:]:
        if not line.startswith(" "):
            block = line
        elif block == "BO":
            face, numbers = line.split()[0], [float(n) for n in re.findall(r"-?\d+\.\d*", line)]
            features.append(Feature("hole", face.replace("h", "v"), *numbers[:3]))
    section = Section(head[7].strip(), h, b, tf, tw, r)
    return Bar(section, length, ends, tuple(features))  # type: ignore[arg-type]


# --- the part in the program ----------------------------------------------------------------------


def places(bar: Bar, cuts: Sequence[Cut], name: str) -> Iterator[tuple[float, Cut, Cut]]:
    """x on the bar at which the part may begin, and the cuts that give it both its ends."""
    cell, near = CELLS[name], 2 * CELLS[name].digits + ROUNDED
    web, flange = bar.ends[:2], bar.ends[2:]
    edge = (bar.section.height if cell.pivot_at_top else 0.0), 0.0
    offsets = [
        end_x(bar.section, bar.length, web[k], flange[k], bool(k), *edge)
        + (k - 0.5) * cell.kerf_x(web[k], flange[k])
        for k in (0, 1)
    ]

    def sawn(k: int, x: float) -> Cut | None:
        fitting = (
            cut
            for cut in cuts
            if abs(cut.x - x) <= near
            and abs(cut.web_deg - web[k]) <= 0.006
            and abs(cut.tilt_deg - tilt_of(web[k], flange[k])) <= 0.006
        )
        return next(fitting, None)

    for first in cuts:
        start = first.x - offsets[0]
        if last := sawn(1, start + offsets[1]) if sawn(0, first.x) else None:
            yield start, first, last


def into_it(bar: Bar, start: float, cuts: Sequence[Cut], name: str) -> Iterator[Cut]:
    """Cuts that go into the part, seen on the edges of the side that the bar lies on."""
    cell, section = CELLS[name], bar.section
    edge = section.height if cell.pivot_at_top else 0.0
    for cut in cuts:
        turn = radians(cut.web_deg)
        for y, z in section.edges():
            x = cut.x - start - (y - edge) * tan(turn)
            x -= z * tan(radians(cut.tilt_deg)) / cos(turn)
            first, last = (
                end_x(section, bar.length, *bar.ends[k::2], bool(k), y, z) for k in (0, 1)
            )
            if first + 0.1 < x < last - 0.1:
                yield cut


def take(bar: Bar, start: float, made: list[Stroke], name: str) -> list[Stroke]:
    """The strokes that are left when the part's are taken. Raises Missing."""
    left = list(made)
    for feature in bar.features:
        for wanted in _strokes(feature, bar.section, name):
            kind = wanted[0]
            if kind == "shape":
                left = _take_shape(feature, start, left, wanted[3])
                continue
            found = next((s for s in left if _is(s, wanted, feature, start, name)), None)
            if found is None:
                raise Missing(f"{wanted} of {feature} at {start}: {left[:12]}")
            left.remove(found)
    return left


Wanted = tuple[str, float, float, float]  #: kind, least and greatest diameter, depth


def _strokes(feature: Feature, section: Section, name: str) -> list[Wanted]:
    """The strokes that make a feature."""
    d, through = feature.diameter, section.wall(feature.face) + BREAKTHROUGH
    if CELLS[name].strokes_fixed:  # the annex: 150 down, or half the height from the side
        through = 150.0 if feature.face == "v" else section.height / 2
    depth = through if feature.depth is None else feature.depth
    match feature.kind:
        case "hole":
            return [("drill", d - 0.3, d + (0.4 if d <= 20 else 0.5), depth)]
        case "thread":
            drill = THREADS[d][1]
            return [("drill", drill, drill, depth), ("tap", d, d, depth)]
        case "sink":  # a cone of 90 degrees is as deep as half its diameter
            return [("sink", d, d, d / 2)]
        case "point":
            return [("punch", 3.0, 3.0, 1.0)]
    return [("shape", d, d, depth)]


def _is(stroke: Stroke, wanted: Wanted, feature: Feature, start: float, name: str) -> bool:
    kind, least, greatest, depth = wanted
    near = 2 * CELLS[name].digits + ROUNDED
    (x, y), *more = stroke.places
    return (
        stroke.kind == kind
        and stroke.face == feature.face
        and not more
        and abs(x - start - feature.x) <= near
        and abs(y - feature.y) <= near
        and least - 1e-9 <= stroke.diameter <= greatest + 1e-9
        and (kind != "tap" or stroke.pitch == THREADS[feature.diameter][0])
        and abs(stroke.depth - depth) <= ROUNDED
    )


def _take_shape(feature: Feature, start: float, made: list[Stroke], depth: float) -> list[Stroke]:
    """Without what mills a slot or scribes a line; all of it has to be as deep, and no more."""
    x, y = start + feature.x, feature.y
    line = shapely.LineString([(x, y), (x + feature.length, y)])
    if feature.kind == "line":
        own = [s for s in made if s.kind == "scribe" and s.face == feature.face
               and line.buffer(0.01).covers(shapely.LineString(s.places))]  # fmt: skip
        drawn = shapely.union_all([shapely.LineString(s.places) for s in own])
        if not _deep(own, SCRIBED) or abs(drawn.length - feature.length) > 0.01:
            raise Missing(f"{feature}: {own}")
        return [s for s in made if s not in own]
    wanted = line.buffer(feature.diameter / 2, quad_segs=64)
    about = wanted.buffer(0.05)
    own = [
        s for s in made
        if s.face == feature.face and s.kind in ("drill", "mill") and about.covers(_swept(s))
    ]  # fmt: skip
    got = shapely.union_all([_swept(s) for s in own])
    # The mill goes round the edge; what it leaves in the middle falls out.
    filled = shapely.union_all([shapely.Polygon(p.exterior) for p in _polygons(got)])
    off = shapely.symmetric_difference(filled, wanted).area
    if not _deep(own, depth) or off > 0.01 * wanted.area:
        raise Missing(f"{feature}: {own}")
    return [s for s in made if s not in own]


def _deep(made: Sequence[Stroke], depth: float) -> bool:
    return all(abs(stroke.depth - depth) <= ROUNDED for stroke in made)


def _polygons(shape: shapely.Geometry) -> list[shapely.Polygon]:
    return [p for p in getattr(shape, "geoms", [shape]) if not p.is_empty]


def _swept(stroke: Stroke) -> shapely.Geometry:
    way = shapely.LineString([*stroke.places, stroke.places[-1]])
    return way.buffer(stroke.diameter / 2, quad_segs=64)


class Laid(NamedTuple):
    """A part on the bar, and the lines of its first cut, its last work and its last cut."""

    start: float
    first: int
    worked: int
    last: int


def compare(program: str, bars: Sequence[Bar], name: str, lettered: bool = False) -> None:
    """All parts are sawn out of the bar with all their features, and nothing else is made.

    The strokes of letters are left to `test_letters`.
    Raises Missing.
    """
    strokes, cuts = run(program, name, bars[0].section)
    if lettered:
        strokes = [stroke for stroke in strokes if stroke.kind != "scribe"]

    def laid(left: Sequence[Bar], made: list[Stroke], taken: list[Laid]) -> list[Laid]:
        if not left:
            if made:
                raise Missing(f"too much: {made}")
            return taken
        said: list[Missing] = []
        for start, first, last in places(left[0], cuts, name):
            if any(abs(start - other.start) < 1.0 for other in taken):
                continue
            try:
                rest = take(left[0], start, made, name)
                if wrong := [*into_it(left[0], start, cuts, name)]:
                    raise Missing(f"cut into: {wrong}")
                own = max((s.line for s in made if s not in rest), default=0)
                return laid(left[1:], rest, [*taken, Laid(start, first.line, own, last.line)])
            except Missing as missing:
                said.append(missing)
        raise Missing(f"{left[0]} is not on the bar of {cuts}: {said}")

    pieces = sorted(laid(bars, strokes, []))
    if CELLS[name].one_way:
        return
    # A pusher loses a part at its last cut: all its work is done before, the next begins behind.
    for piece in pieces:
        if not (piece.first < piece.last and piece.worked < piece.last):
            raise Missing(f"out of order: {piece} of {cuts}")
    for piece, following in pairwise(pieces):
        if following.first < piece.last:
            raise Missing(f"parted off before it is sawn: {piece}, {following} of {cuts}")


# --- 200 bars, the samples and the golden programs ------------------------------------------------

NAMES = tuple(CELLS)


def posted(bars: Sequence[Bar], name: str) -> str:
    parts = [
        part
        for k, bar in enumerate(bars)
        for part in readers.read(bar.file(f"P{k}").encode(), f"p{k}.nc1").parts
    ]
    return post(parts, load(name)).text


@pytest.mark.parametrize("seed", range(0, 200, 10))
def test_random_bars(seed: int) -> None:
    for each in range(seed, seed + 10):
        name = NAMES[each % 3]
        bars = random_bar(name, Random(each))
        compare(posted(bars, name), bars, name)


def test_the_random_bars_have_all_kinds() -> None:
    every = [(name, bar) for k in range(200) for name in [NAMES[k % 3]]
             for bar in random_bar(name, Random(k))]  # fmt: skip
    kinds = Counter((f.kind, f.face) for _, bar in every for f in bar.features)
    assert {kind for kind, _ in kinds} == {
        "hole", "thread", "sink", "point", "slot", "line",
    }  # fmt: skip
    assert min(kinds.values()) >= 3
    assert Counter(bar.section.code for _, bar in every).keys() == {*"IULMCT"}
    assert sum(any(bar.ends[:2]) for _, bar in every) > 50
    assert sum(any(bar.ends[2:]) for _, bar in every) > 10


def test_the_end_of_a_tube_is_sawn_before_it_is_parted_off() -> None:
    """X of the mitre counts on a corner that is round: beyond what parts the piece off there."""
    tube = Section("M", 200.0, 120.0, 8.0, 8.0, 12.0)
    bars = [
        Bar(tube, 2000.0, (0.0, 5.0, 0.0, 10.0), ()),
        Bar(tube, 2000.0, (-12.5, 0.0, 0.0, 0.0), ()),
    ]
    program = posted(bars, "beamline-pusher")
    compare(program, bars, "beamline-pusher")
    _, cuts = run(program, "beamline-pusher", tube)
    assert [cut.web_deg for cut in cuts] == [0.0, 5.0, 0.0, -12.5, 0.0]
    assert cuts[2].x < cuts[1].x


#: Samples that a cell makes; the rest are plates, and sections and copes that none of them makes.
MADE = [
    (name, sample) for name in NAMES for sample in ("beam", "channel", "tie", "strut", "marked")
]


@pytest.mark.parametrize(("name", "sample"), MADE)
def test_samples(name: str, sample: str) -> None:
    text = (SAMPLES / "dstv" / f"{sample}.nc1").read_text()
    parts = readers.read(text.encode(), f"{sample}.nc1").parts
    compare(post(parts[:1], load(name)).text, [read_bar(text)], name, lettered="SI" in text)


PROGRAMS = [path for name in NAMES for path in sorted((GOLDEN / name).glob("*.gcode"))]


@pytest.mark.parametrize("path", PROGRAMS, ids=lambda p: f"{p.parent.name}/{p.name}")
def test_golden_programs(path: Path) -> None:
    samples = path.stem.split("+")
    bars = [read_bar((SAMPLES / "dstv" / f"{sample}.nc1").read_text()) for sample in samples]
    compare(path.read_text(), bars, path.parent.name)


def test_there_are_golden_programs() -> None:
    assert len(PROGRAMS) >= 12


#: What is done to a program, and what the stranger says of it.
FAULTS = [
    (r"G01 X858.56 Y70 Z87.159", "G01 X858.56 Y70 Z86.159"),
    (r"G01 X858.56 Y70 Z87.159", "G01 X859.56 Y70 Z87.159"),
    (r"M40 K1 L18", "M40 K3 L18"),
    (r"M40 K2 L13", "M40 K2 L14"),
    (r"M40 K13 L18", "M40 K1 L18"),
    (r"G00 X4222.02", "G00 X4221.02"),
    (r"M42 K0", "M42 K1"),
    (r"M44 K150", "M44 K160"),
    (r"M43 K1", "M43 K2"),
    (r"X2898.56 Y0", "X2898.56 Y1"),
]


@pytest.mark.parametrize(("good", "bad"), FAULTS)
def test_the_stranger_sees_a_fault(good: str, bad: str) -> None:
    program = (GOLDEN / "beamline" / "beam.gcode").read_text()
    assert good in program
    bars = [read_bar((SAMPLES / "dstv" / "beam.nc1").read_text())]
    with pytest.raises((Missing, CellError)):
        compare(program.replace(good, bad), bars, "beamline")
