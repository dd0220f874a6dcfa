"""Parts, machines and programs for `solid.py`: of the samples, of real files and random ones.

A part of which nothing is symmetric has a mirror image that is another one.
"""

from collections.abc import Collection, Iterator, Sequence
from math import pi
from pathlib import Path
from random import Random
from typing import Any

from msgspec import Struct
from msgspec.structs import replace

from beamcam.errors import BeamcamError, Diagnostic, Severity, Source
from beamcam.geometry.curves import Arc, Line
from beamcam.machine import Machine, load
from beamcam.model.part import Contour, EndCuts, Hole, Part, Profile, Slot
from beamcam.model.request import Request
from beamcam.pipeline import post, read_file
from beamcam.solid.opinion import solid_faults
from beamcam.solid.part_solid import part_solid
from tests.random_boxes import random_box
from tests.random_copes import random_cope
from tests.random_tubes import random_tube

ROOT = Path(__file__).resolve().parent.parent
BARS = ("beamline", "beamline-annex", "beamline-pusher")
SHEETS = ("plate-linuxcnc", "plate-codesys", "plate-oxyfuel", "laser-grbl")
#: The machines of a kind of stock, of which each makes a random part.
MACHINES = {
    "bars": BARS, "plates": SHEETS[:3],
    "profiles": ("coper-linuxcnc", "tube-linuxcnc"), "tubes": ("tube-linuxcnc",),
}  # fmt: skip
PIPE = "PIPE"  #: how a plate is called that is the unrolled surface of one
SUFFIXES = (".nc", ".nc1", ".json", ".dxf", ".svg", ".ifc")
MEMBERS = 12  #: of a building model, at most
NEAR = 0.1  #: mm; real files round places by as much
SOURCE = Source("random", 1)


class Case(Struct, frozen=True):
    """A part, a machine, and the program that makes the one on the other."""

    name: str
    part: Part
    machine: Machine
    text: str

    def said(self, text: str, skips: tuple[str, ...] = ()) -> list[Diagnostic]:
        """What is wrong with a program for the part, notes aside; `skips` may be left out."""
        found = solid_faults(text, Request((self.part,), self.machine, skips))
        return [d for d in found if d.severity is not Severity.NOTE]


def stock_of(part: Part, machine: Machine) -> str:
    """What kind of stock a machine makes a part from."""
    if machine.coper is not None:
        return "tubes" if machine.coper.unrolls(part.profile.code) else "profiles"
    return "plates" if part.profile.code == "B" else "bars"


def posted(part: Part, machine: Machine) -> str | None:
    """The program of a part; None where the machine does not make it."""
    try:
        return post([part], machine, skips=("all",), verified=False).text
    except BeamcamError:
        return None


def files(corpus: Path | None) -> Iterator[Path]:
    """All inputs of the samples, and real ones."""
    for folder in (ROOT / "samples", corpus):
        if folder is not None and folder.is_dir():
            yield from sorted(p for p in folder.rglob("*") if p.suffix.lower() in SUFFIXES)


def parts_in(path: Path) -> Sequence[Part]:
    """The parts of a file that can be read; of a drawing without units in mm."""
    options = {"units": "mm"} if path.suffix == ".dxf" else {}
    for asked in ({}, options):
        try:
            reading = read_file(str(path), **asked)
        except BeamcamError:
            continue
        if reading.parts and not any(d.severity is Severity.ERROR for d in reading.diagnostics):
            return reading.parts[:MEMBERS]
    return ()


def machines_for(part: Part) -> Iterator[Machine]:
    """The machines that may make a part; a table for drawings cuts all colours that it does not
    know, and takes a sheet of a thickness and a material in its chart."""
    names = SHEETS if part.profile.code == "B" else BARS
    if part.profile.code in ("I", "U", "L"):
        names += MACHINES["profiles"]
    elif part.profile.code in ("RO", "M") or part.profile.name.startswith(PIPE):
        names += MACHINES["tubes"]
    for machine in map(load, names):
        torch = machine.torch
        if torch is None:
            yield machine
            continue
        looks = {c.colour or c.layer for c in part.contours if c.colour or c.layer}
        colours = {**dict.fromkeys(filter(None, looks), "cut"), **torch.colours}
        material = {} if torch.material else {"material": "acrylic"}
        thick = {} if torch.thickness else {"thickness": 3.0}
        yield replace(
            machine, torch=replace(torch, colours=colours, allow_open=True, **material, **thick)
        )


def cases(corpus: Path | None, stocks: Collection[str]) -> Iterator[Case]:
    """Each part on each machine that makes it, of some kinds of stock."""
    for path in files(corpus):
        for part in parts_in(path):
            for machine in machines_for(part):
                text = posted(part, machine) if stock_of(part, machine) in stocks else None
                if text is not None:
                    name = f"{path.name} {part.mark} {machine.name}"
                    yield Case(name, part, machine, text)


def random_bar(rng: Random) -> Part:
    h, b = rng.choice([(200.0, 100.0), (300.0, 150.0), (120.0, 80.0)])
    t, s, r = rng.choice([(11.0, 7.0, 12.0), (9.0, 8.0, 0.0)])
    code = rng.choice(["I", "U", "L"])
    if code == "L":
        s = t
    profile = Profile(code, f"{code}{h:g}", h, b, t, s, r)  # type: ignore[arg-type]
    length = float(rng.randrange(800, 3000))
    faces = {"I": "vou", "U": "vou", "L": "vu"}[code]
    holes = []
    for k in range(rng.randrange(3, 7)):
        face = "v" if k == 0 else rng.choice(faces)
        if face == "v":
            y = rng.uniform(t + r + 15, h - (t + r + 15 if code != "L" else 20))
        else:
            low, high = (s + r + 12, b - 15) if code != "I" else (15.0, (b - s) / 2 - r - 10)
            y = rng.uniform(low, high) if high > low else (low + high) / 2
        x = 150.0 + (length - 300) * (k + rng.random() * 0.5) / 7
        wall = s if face == "v" else t
        blind = rng.random() < 0.4
        size = float(rng.choice([12, 14, 18]))
        holes.append(
            Hole(face, round(x, 1), round(y, 1), size, SOURCE, wall / 2 if blind else None,
                 "blind" if blind else "through")
        )  # fmt: skip
    cuts = EndCuts(web_end=float(rng.choice([0, 12, 25, -20])))
    return Part("RANDOM", profile, length, SOURCE, cuts=cuts, features=tuple(holes))


def closed(points: Sequence[tuple[float, float]]) -> tuple[Line, ...]:
    return tuple(map(Line, points, [*points[1:], points[0]]))


def random_plate(rng: Random) -> Part:
    w, h = float(rng.randrange(150, 500)), float(rng.randrange(120, 300))
    a, c = rng.uniform(30, w / 3), rng.uniform(30, h / 3)
    outline = [(0.0, 0.0), (w, 0.0), (w, h - c), (w - a, h), (0.0, h)]
    features: list[Any] = [Contour("v", "outer", closed(outline), SOURCE)]
    features.append(Hole("v", rng.uniform(25, w / 3), rng.uniform(25, h / 3), 14.0, SOURCE))
    features.append(
        Slot("v", w / 2, rng.uniform(25, h / 2), 12.0, 20.0, 0.0, rng.choice([0.0, 30.0]), SOURCE)
    )
    inner = (Arc((w / 2, h * 0.75), rng.uniform(8, 16), 0.0, 360.0),)
    features.append(Contour("v", "inner", inner, SOURCE))
    profile = Profile("B", "PL6", h, 0.0, 0.0, 6.0)
    return Part("RANDOM", profile, w, SOURCE, grade="S235", features=tuple(features))


def with_feature(part: Part, at: int, feature: Any) -> Part:
    features = [*part.features]
    features[at : at + 1] = [feature] if feature is not None else []
    return replace(part, features=tuple(features))


def mirrored(part: Part) -> Part | None:
    """The part with its x reversed, or None where that is not only a matter of holes and curves."""
    if part.made is not None:
        return None
    flip = ((-1.0, 0.0, part.length), (0.0, 1.0, 0.0))
    features: list[Any] = []
    for f in part.features:
        if isinstance(f, Contour):
            if f.bevels or f.notches:
                return None
            curves = tuple(c.transformed(flip).reversed() for c in reversed(f.curves))
            features.append(replace(f, curves=curves))
        elif isinstance(f, Slot):
            features.append(replace(f, x=part.length - f.x, angle=180 - f.angle))
        elif isinstance(f, Hole):
            features.append(replace(f, x=part.length - f.x))
    c = part.cuts
    cuts = EndCuts(-c.web_end, -c.web_start, -c.flange_end, -c.flange_start)
    return replace(part, features=tuple(features), cuts=cuts)


def is_its_image(case: Case) -> bool:
    """Whether the part is its own mirror image, by moments of its solid that a turn keeps.

    What a mirror changes of a bar is the sign of the third moment xyz about its middle, and of
    which ends and sides are heavier; a plate shows it in its own plane, v on top. Holes that are
    where their images are, within `NEAR`, make no other part.
    """
    try:
        body = part_solid(case.part)
    except BeamcamError:
        return True
    flat = case.part.profile.code == "B"
    image = body.mirror((1.0, 0.0, 0.0))
    box = body.bounding_box()
    middle = [(box[k] + box[k + 3]) / 2 for k in range(3)]
    body = body.translate(tuple(-m for m in middle))
    image = image.translate((middle[0], -middle[1], -middle[2]))
    turns = [(0, 0, 0), (0, 0, 180), (0, 0, 90), (0, 0, 270)] if flat else [
        (a, b, 0) for a in (0, 90, 180, 270) for b in (0, 180)]  # fmt: skip
    alike = 50.0 + NEAR * (case.part.profile.web_thickness or 0.0) * sum(
        pi * hole.diameter for hole in case.part.holes)  # fmt: skip
    return any((body - image.rotate(turn)).volume() < alike for turn in turns)


def random_part(stock: str, rng: Random) -> Part:
    """A part of a kind of stock."""
    if stock == "profiles":
        return random_cope(rng.randrange(10**6))
    if stock == "tubes":
        return rng.choice((random_tube, random_box))(rng.randrange(10**6))
    return random_bar(rng) if stock == "bars" else random_plate(rng)
