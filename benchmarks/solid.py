"""How `verify --solid` judges sound programs and wrong ones.

    python benchmarks/solid.py [--mutants 30] [--seed 1] [--corpus FOLDER]

Every bar and plate of the samples, and of real files where FOLDER (or BEAMCAM_CORPUS) has some, is
posted on every machine with G-code that takes it; the third opinion has to agree with each program.
Then programs are made that are wrong in one way, so many of each kind for bars and for plates, from
those parts of which nothing is left out and from random ones, and each has to be refused:

    depth        one stroke ends in the wall, or a blind hole has another depth
    face         a hole on another face
    hand         the mirror image of the part
    kerf side    a cut on the wrong side of its line, or on the line
    missing      a hole, a slot or a cut-out is not made
    length       the part is longer or shorter

Exit status 1 if an opinion is wrong.
"""

import os
import re
import sys
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from math import pi
from pathlib import Path
from random import Random
from typing import Any

from msgspec import Struct
from msgspec.structs import replace

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from beamcam.errors import BeamcamError, Diagnostic, Severity, Source  # noqa: E402
from beamcam.geometry.curves import Arc, Line  # noqa: E402
from beamcam.machine import Machine, load  # noqa: E402
from beamcam.model.part import Contour, EndCuts, Hole, Part, Profile, Slot  # noqa: E402
from beamcam.model.request import Request  # noqa: E402
from beamcam.pipeline import post, read_file  # noqa: E402
from beamcam.solid.opinion import solid_faults  # noqa: E402
from benchmarks.script import arguments, at_least, start  # noqa: E402

BARS = ("beamline", "beamline-annex", "beamline-pusher")
SHEETS = ("plate-linuxcnc", "plate-codesys", "plate-oxyfuel", "laser-grbl")
SUFFIXES = (".nc", ".nc1", ".json", ".dxf", ".svg", ".ifc")
MEMBERS = 12  #: of a building model, at most
NEAR = 0.1  #: mm; real files round places by as much
TRIES = 60  #: for each mutant, until one is there
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


def cases(corpus: Path | None) -> Iterator[Case]:
    """Each part on each machine that makes it."""
    for path in files(corpus):
        for part in parts_in(path):
            for machine in machines_for(part):
                text = posted(part, machine)
                if text is not None:
                    name = f"{path.name} {part.mark} {machine.name}"
                    yield Case(name, part, machine, text)


# Random parts, of which nothing is symmetric


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


# Wrong programs


Wrong = Callable[[Case, Random], str | None]
_STROKE = re.compile(r"(?m)^(N\d+ M40 K(\d+) L(\S+)$)(?s:.*?)^(N\d+ G01 .*)$")
_CUT = re.compile(r"(?m)^(N\d+ G0[01] X)(\S+)(\nN\d+ M4[12] )")


def depth(case: Case, rng: Random) -> str | None:
    """One stroke that ends in its wall, or a blind hole of another depth."""
    drill, strokes = case.machine.drill, [*_STROKE.finditer(case.text)]
    if drill is None or not strokes or case.machine.name == "beamline-annex":
        return None  # whose strokes are as long for any depth
    stroke = rng.choice(strokes)
    axis = "Z" if stroke[2] == "2" else "Y"
    bottom = re.search(rf"{axis}(-?\d+\.?\d*)", stroke[4])
    if bottom is None or any(isinstance(f, Slot) for f in case.part.features):
        # An entry that is drilled too shallow is milled through: the part is as it should be, and
        # the order of work is the read-back's to ask.
        return None
    profile = case.part.profile
    wall = profile.web_thickness if axis == "Z" else profile.flange_thickness
    shallower = drill.breakthrough + rng.uniform(0.2, 0.8) * (wall or 0.0)
    line = stroke[4].replace(bottom[0], f"{axis}{float(bottom[1]) - shallower:.3f}")
    return case.text[: stroke.start(4)] + line + case.text[stroke.end(4) :]


def face(case: Case, rng: Random) -> str | None:
    """A hole of the web in a flange, or of one flange in the other."""
    places = [k for k, f in enumerate(case.part.features) if isinstance(f, Hole)]
    profile = case.part.profile
    if not places or profile.code not in ("I", "U", "L"):
        return None
    at = rng.choice(places)
    hole = case.part.features[at]
    assert isinstance(hole, Hole)
    free = [f for f in ("vu" if profile.code == "L" else "vou") if f != hole.face]
    other = rng.choice(free)
    twin = replace(hole, face=other, y=round(
        profile.height / 2 if other == "v" else profile.width * 0.7, 1))  # fmt: skip
    if any(h.face == other and abs(h.x - twin.x) < 60 for h in case.part.holes):
        return None
    return posted(with_feature(case.part, at, twin), case.machine)


def with_feature(part: Part, at: int, feature: Any) -> Part:
    features = [*part.features]
    features[at : at + 1] = [feature] if feature is not None else []
    return replace(part, features=tuple(features))


def hand(case: Case, rng: Random) -> str | None:
    """The mirror image of the part."""
    image = mirrored(case.part)
    return None if image is None or is_its_image(case) else posted(image, case.machine)


def mirrored(part: Part) -> Part | None:
    """The part with its x reversed, or None where that is not only a matter of holes and curves."""
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
    from beamcam.solid.part_solid import part_solid

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


def kerf_side(case: Case, rng: Random) -> str | None:
    """A cut on the wrong side of its line, or on the line itself."""
    saw, torch = case.machine.saw, case.machine.torch
    if saw is not None:
        cuts = [*_CUT.finditer(case.text)]
        if not cuts:
            return None
        ends = sorted(cuts, key=lambda cut: float(cut[2]))
        first = rng.random() < 0.5
        cut = ends[0] if first else ends[-1]
        x = float(cut[2]) + (saw.kerf if first else -saw.kerf)
        return case.text[: cut.start(2)] + f"{x:.3f}" + case.text[cut.end(2) :]
    if torch is None or torch.kerf_by != "offset":
        return None
    if rng.random() < 0.5:
        return posted(case.part, replace(case.machine, torch=replace(torch, kerf_by="none")))
    by_machine = replace(case.machine, torch=replace(torch, kerf_by="machine"))
    text = posted(case.part, by_machine)
    sides = {"1": "2", "2": "1"}
    return text and re.sub(r"G4([12])(?=\D)", lambda m: f"G4{sides[m[1]]}", text)


def missing(case: Case, rng: Random) -> str | None:
    """A hole, a slot or a cut-out is not made."""
    places = [
        k for k, f in enumerate(case.part.features)
        if (isinstance(f, Hole | Slot) and f.kind != "mark")
        or (isinstance(f, Contour) and f.kind == "inner" and f.process == "cut")
    ]  # fmt: skip
    if not places:
        return None
    at = rng.choice(places)
    return posted(with_feature(case.part, at, None), case.machine)


def length(case: Case, rng: Random) -> str | None:
    """The part is longer or shorter, behind its last hole."""
    part = case.part
    off = rng.choice([-1, 1]) * rng.uniform(0.6, 8.0)
    if case.machine.torch is not None:
        outer = [k for k, f in enumerate(part.features) if isinstance(f, Contour)
                 and f.kind == "outer"]  # fmt: skip
        if len(outer) != 1 or part.measures is not None:
            return None
        contour = part.features[outer[0]]
        assert isinstance(contour, Contour)
        if not all(isinstance(c, Line) for c in contour.curves):
            return None
        points = [c.start for c in contour.curves]
        middle = (min(x for x, _ in points) + max(x for x, _ in points)) / 2
        moved = [(x + off if x > middle else x, y) for x, y in points]
        part = with_feature(part, outer[0], replace(contour, curves=closed(moved)))
    elif any(isinstance(f, Contour) for f in part.features):
        return None
    return posted(replace(part, length=part.length + off), case.machine)


#: Each way to be wrong, by the stock that it is possible with.
KINDS: dict[str, tuple[tuple[str, Wrong], ...]] = {
    "bars": (
        ("depth", depth), ("face", face), ("hand", hand), ("kerf side", kerf_side),
        ("missing", missing), ("length", length),
    ),
    "plates": (
        ("hand", hand), ("kerf side", kerf_side), ("missing", missing), ("length", length),
    ),
}  # fmt: skip
NO_SOLID = ("solid-none",)


def drawn_from(known: Sequence[Case], stock: str, rng: Random) -> Case | None:
    """A case of what was read, or one of a random part."""
    if known and rng.random() < 0.5:
        return rng.choice(known)
    part = random_bar(rng) if stock == "bars" else random_plate(rng)
    machine = load(rng.choice(BARS if stock == "bars" else SHEETS[:3]))
    text = posted(part, machine)
    case = text and Case(f"random on {machine.name}", part, machine, text)
    return case or None


def _words(text: str) -> str:
    """A program without its comments."""
    return re.sub(r"\(.*?\)|;.*", "", text)


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--mutants", type=at_least(1), default=30, help="of each kind; default 30")
    parser.add_argument("--seed", type=int, default=1, help="default 1")
    parser.add_argument("--corpus", help="folder of real files; by default BEAMCAM_CORPUS")
    asked = parser.parse_args()
    given = asked.corpus or os.environ.get("BEAMCAM_CORPUS")
    corpus = Path(given) if given else None
    if corpus is None or not corpus.is_dir():
        print("no corpus: samples only")
        corpus = None
    agreed: Counter[str] = Counter()
    wrong: list[str] = []
    sound: dict[str, list[Case]] = {"bars": [], "plates": []}
    for case in cases(corpus):
        stock = "plates" if case.part.profile.code == "B" else "bars"
        said = case.said(case.text, ("all",))
        if any(d.code in NO_SOLID for d in said):
            agreed[f"{stock} without a solid"] += 1
            print(f"no solid: {case.name}: {said[0].message}")
        elif said:
            wrong.append(f"{case.name}: {said[0]}")
        else:
            agreed[stock] += 1
            request = Request((case.part,), case.machine)
            if not solid_faults(case.text, request):  # nor a note: nothing of it is left out
                sound[stock].append(case)
    for stock, count in sorted(agreed.items()):
        print(f"{count} programs: {stock}" + (", agreed" if stock in KINDS else ""))
    for stock, kinds in KINDS.items():
        for kind, make in kinds:
            made, missed = mutants(sound[stock], stock, kind, make, asked.mutants, asked.seed)
            print(f"{stock} {kind:10} {made - len(missed):4} of {made:4} refused")
            wrong += missed
            if made < asked.mutants:
                wrong.append(f"{stock} {kind}: only {made} mutants")
    print(*(f"WRONG {one}" for one in wrong), sep="\n", end="\n" if wrong else "")
    sys.exit(1 if wrong else 0)


def mutants(
    known: Sequence[Case], stock: str, kind: str, make: Wrong, count: int, seed: int
) -> tuple[int, list[str]]:
    """How many programs of a kind were made, and which of them were not refused."""
    rng = Random(f"{seed} {stock} {kind}")
    made, missed = 0, []
    for _ in range(TRIES * count):
        if made == count:
            break
        case = drawn_from(known, stock, rng)
        text = case and make(case, rng)
        # Words alone make something: of a hole beside the steel nothing but the head tells.
        if case is None or text is None or _words(text) == _words(case.text):
            continue
        made += 1
        if not case.said(text):
            missed.append(f"{kind} of {case.name} was not refused")
    return made, missed


if __name__ == "__main__":
    start(main)
