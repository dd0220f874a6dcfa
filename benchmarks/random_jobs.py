"""Random bars and random plates: each is posted, and none may be refused by its own read-back.

Bars are parts as DSTV files, one to three of a section on a bar (`tests/random_bars.py`), for each
saw and drill line by turns. Plates are drawings of outlines with straight and round edges and
notches, with holes, slots, windows, islands in windows, marks and letters, for each table and laser
by turns with its own kinds of kerf, lead and start. What the planner refuses for a reason of its
own is counted by its code.

    python benchmarks/random_jobs.py [--bars 300] [--plates 300] [--seed 1]

Exit status 1 if the read-back refuses one, or something else than an error of ours comes.
"""

import random
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from math import cos, hypot, pi, sin
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from beamcam.errors import BeamcamError, Severity, Source
from beamcam.geometry.curves import Arc, Curve, Line, arc_through
from beamcam.machine import Machine, load
from beamcam.machine.overlay import with_torch
from beamcam.model.part import Contour, Measures, Part, Profile, TextMark
from beamcam.pipeline import post
from beamcam.readers import read
from benchmarks.script import arguments, at_least, start
from tests.random_bars import random_bar

LINES = ("beamline", "beamline-annex", "beamline-pusher")
#: Tables with what their cuts may be made with.
TABLES: tuple[tuple[str, dict[str, tuple[object, ...]]], ...] = (
    ("plate-linuxcnc", {"kerf_by": ("offset", "machine", "none"), "lead": ("arc", "line", "none")}),
    ("plate-codesys", {"kerf_by": ("offset", "machine"), "lead": ("arc", "line")}),
    ("plate-oxyfuel", {"thickness": (10.0, 20.0), "lead": ("arc", "line")}),
    ("plate-qtplasmac", {"lead": ("arc", "line"), "drilled": ("spot", "mark")}),
    ("laser-grbl", {"material": ("wood",), "kerf_by": ("offset", "none")}),
)
Point = tuple[float, float]
S = Source("plate.dxf", 1)


def joined(points: list[Point]) -> tuple[Curve, ...]:
    return tuple(map(Line, points, [*points[1:], points[0]]))


def outline(
    chance: random.Random, centre: Point, size: float, corners: int = 3
) -> tuple[Curve, ...]:
    """A closed chain of so many corners or more about a point, within `size` of it.

    Corners stand at rising angles round it, so that no two edges meet; each edge is straight or an
    arc so flat that it stays beside its neighbours.
    """
    (x, y), count = centre, chance.randint(corners, 9)
    turn = chance.uniform(0, 2 * pi)
    angles = [turn + 2 * pi * (k + chance.uniform(0.0, 0.5)) / count for k in range(count)]
    points = [
        (round(x + reach * cos(a), 3), round(y + reach * sin(a), 3))
        for a, reach in zip(angles, (size * chance.uniform(0.75, 1.0) for _ in angles), strict=True)
    ]
    found: list[Curve] = []
    for a, b in zip(points, [*points[1:], points[0]], strict=True):
        chord = hypot(b[0] - a[0], b[1] - a[1])
        if count > 3 and chance.random() < 0.3:
            found.append(arc_through(a, b, chord * chance.uniform(3.0, 6.0)))
        else:
            found.append(Line(a, b))
    return tuple(found)


def slot(chance: random.Random, centre: Point, size: float) -> tuple[Curve, ...]:
    """A slot with round ends."""
    (x, y), r = centre, size * chance.uniform(0.3, 0.45)
    half = size - r
    return (
        Line((x - half, y - r), (x + half, y - r)), Arc((x + half, y), r, -90.0, 180.0),
        Line((x + half, y + r), (x - half, y + r)), Arc((x - half, y), r, 90.0, 180.0),
    )  # fmt: skip


def hole(chance: random.Random, centre: Point, size: float) -> tuple[Curve, ...]:
    return (Arc(centre, size, 0.0, 360.0),)


def rectangle(chance: random.Random, centre: Point, size: float) -> tuple[Curve, ...]:
    (x, y), high = centre, size * chance.uniform(0.3, 0.7)
    wide = size * 0.7
    return joined([(x - wide, y - high), (x + wide, y - high), (x + wide, y + high),
                   (x - wide, y + high)])  # fmt: skip


OPENINGS = (hole, hole, slot, rectangle, outline)


def plate(chance: random.Random) -> Part:
    """A drawing of an outline with openings on a grid within it, some with an island, and marks."""
    size = chance.uniform(90, 190)
    centre = (size + 20.0, size + 20.0)
    features: list[Contour | TextMark] = [cut("outer", outline(chance, centre, size, 6))]
    pitch = size / 3.2
    for i in (-1, 0, 1):
        for j in (-1, 0, 1):
            at = (centre[0] + i * pitch * 0.8, centre[1] + j * pitch * 0.8)
            if hypot(i, j) * pitch * 0.8 > size * 0.36 or chance.random() < 0.3:
                continue
            reach = pitch * chance.uniform(0.14, 0.32)
            kind = chance.random()
            if kind < 0.75:
                features.append(cut("inner", chance.choice(OPENINGS)(chance, at, reach)))
                if reach > 22.0 and isinstance(features[-1].curves[0], Arc):  # type: ignore[union-attr]
                    features.append(cut("outer", hole(chance, at, reach * 0.4)))
            elif kind < 0.9:
                line = Line((at[0] - reach, at[1]), (at[0] + reach, at[1] + chance.uniform(0, 5)))
                mark = Contour("v", "open", (line,), S, "engrave", False, colour="#0000ff")
                features.append(mark)
            else:
                features.append(
                    TextMark("v", at[0] - reach, at[1], chance.choice((0.0, 90.0)), 5.0, "A7", S)
                )
    return Part(
        "SHEET", Profile("B", "", 0.0, 0.0, 0.0, 6.0), 0.0, S, features=tuple(features),
        measures=Measures(),
    )  # fmt: skip


def cut(kind: str, curves: tuple[Curve, ...]) -> Contour:
    return Contour("v", kind, curves, S, "cut", True, colour="#ff0000")  # type: ignore[arg-type]


def bars(count: int, seed: int) -> Iterator[tuple[str, Callable[[], object]]]:
    for k in range(count):
        name = LINES[k % len(LINES)]
        made = random_bar(name, random.Random(f"{seed} bar {k}"))
        files = [read(bar.file(f"R{n}").encode(), f"R{n}.nc1") for n, bar in enumerate(made)]
        parts = [part for one in files for part in one.parts]
        assert len(parts) == len(made), [str(d) for one in files for d in one.diagnostics]
        yield name, lambda parts=parts, name=name: post(parts, load(name), bar=12_000.0)  # type: ignore[misc]


def plates(count: int, seed: int) -> Iterator[tuple[str, Callable[[], object]]]:
    for k in range(count):
        chance = random.Random(f"{seed} plate {k}")
        name, choices = TABLES[k % len(TABLES)]
        machine = table(name, {key: chance.choice(values) for key, values in choices.items()})
        part = plate(chance)
        yield name, lambda part=part, machine=machine: post([part], machine)  # type: ignore[misc]


def table(name: str, values: dict[str, object]) -> Machine:
    return with_torch(load(name), **values)  # type: ignore[arg-type]


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--bars", type=at_least(0), default=300)
    parser.add_argument("--plates", type=at_least(0), default=300)
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    wrong = 0
    for what, jobs in (
        ("bars", bars(asked.bars, asked.seed)), ("plates", plates(asked.plates, asked.seed)),
    ):  # fmt: skip
        posted: Counter[str] = Counter()
        refused: Counter[str] = Counter()
        for number, (name, job) in enumerate(jobs):
            try:
                job()
                posted[name] += 1
            except BeamcamError as error:
                codes = {d.code for d in error.diagnostics if d.severity is Severity.ERROR}
                refused.update(codes)
                if any(code.startswith(("verify-", "steps-")) for code in codes):
                    wrong += 1
                    print(f"{what} {number} on {name}: {', '.join(sorted(codes))}")
        by_machine = ", ".join(f"{count} {name}" for name, count in posted.items())
        print(f"{what}: {posted.total()} posted ({by_machine})")
        print(f"{what}: refused by the planner: {dict(refused) or 'none'}")
    print(f"refused by the read-back: {wrong}")
    sys.exit(min(wrong, 1))


if __name__ == "__main__":
    start(main)
