"""How `verify --solid` judges sound programs and wrong ones.

    python benchmarks/solid.py [--mutants 30] [--seed 1] [--corpus FOLDER] [--stock STOCK]

Every bar, plate, coped profile and tube of the samples, and of real files where FOLDER (or
BEAMCAM_CORPUS) has some, is posted on every machine with G-code that takes it; the third opinion
has to agree with each program. Then programs are made that are wrong in one way, so many of each
kind for each kind of stock, from those parts of which nothing is left out and from random ones, and
each has to be refused:

    depth        one stroke ends in the wall, or a blind hole has another depth
    face         a hole on another face; of a tube a cut-out a quarter of a turn on
    hand         the mirror image of the part
    kerf side    a cut on the wrong side of its line, or on the line
    missing      a hole, a slot, a cut-out or the cut of an end is not made
    length       the part is longer or shorter
    cope moved   a cope, a notch or an end of a profile or a tube 1 mm along it
    A            the torch looks at another wall; of a tube, one place of a cut-out is 9 degrees off
    seam         an end of a tube that is not cut all round

Exit status 1 if an opinion is wrong.
"""

import os
import re
import sys
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from random import Random

from msgspec.structs import replace

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from beamcam.geometry.curves import Line
from beamcam.machine import load
from beamcam.model.part import Contour, Hole, Slot
from beamcam.model.request import Request
from beamcam.solid.opinion import solid_faults
from benchmarks import solid_copers as copers
from benchmarks.script import arguments, at_least, start
from benchmarks.solid_cases import (
    MACHINES,
    Case,
    cases,
    closed,
    is_its_image,
    mirrored,
    posted,
    random_part,
    stock_of,
    with_feature,
)

TRIES = 60  #: for each mutant, until one is there

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
    return case.text[: stroke.retract(4)] + line + case.text[stroke.end(4) :]


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


def hand(case: Case, rng: Random) -> str | None:
    """The mirror image of the part."""
    image = mirrored(case.part)
    return None if image is None or is_its_image(case) else posted(image, case.machine)


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
    "profiles": (
        ("face", face), ("hand", hand), ("kerf side", copers.kerf_side),
        ("missing", copers.missing), ("length", copers.length), ("cope moved", copers.cope_moved),
        ("A", copers.angle),
    ),
    "tubes": (
        ("face", copers.elsewhere), ("hand", hand), ("kerf side", copers.kerf_side),
        ("missing", copers.missing), ("length", copers.length), ("cope moved", copers.cope_moved),
        ("A", copers.angle), ("seam", copers.seam),
    ),
}  # fmt: skip
NO_SOLID = ("solid-none",)


def drawn_from(known: Sequence[Case], stock: str, rng: Random) -> Case | None:
    """A case of what was read, or one of a random part."""
    if known and rng.random() < 0.5:
        return rng.choice(known)
    part, machine = random_part(stock, rng), load(rng.choice(MACHINES[stock]))
    text = posted(part, machine)
    case = text and Case(f"random on {machine.name}", part, machine, text)
    return case or None


def _words(text: str) -> list[str]:
    """The blocks of a program without its comments."""
    blocks = (re.sub(r"\(.*?\)|;.*", "", line).strip() for line in text.splitlines())
    return [block for block in blocks if block]


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--mutants", type=at_least(1), default=30, help="of each kind; default 30")
    parser.add_argument("--seed", type=int, default=1, help="default 1")
    parser.add_argument("--corpus", help="folder of real files; by default BEAMCAM_CORPUS")
    parser.add_argument("--stock", choices=KINDS, help="of this kind only")
    asked = parser.parse_args()
    given = asked.corpus or os.environ.get("BEAMCAM_CORPUS")
    corpus = Path(given) if given else None
    if corpus is None or not corpus.is_dir():
        print("no corpus: samples only")
        corpus = None
    agreed: Counter[str] = Counter()
    wrong: list[str] = []
    stocks = [asked.stock] if asked.stock else [*KINDS]
    sound: dict[str, list[Case]] = {stock: [] for stock in stocks}
    for case in cases(corpus, stocks):
        stock = stock_of(case.part, case.machine)
        said = case.said(case.text, ("all",))
        if any(d.code in NO_SOLID for d in said):
            agreed[f"{stock} without a solid"] += 1
            print(f"no solid: {case.name}: {said[0].message}")
        elif said:
            wrong.append(f"{case.name}: {said[0]}")
        else:
            agreed[stock] += 1
            request = Request((case.part,), case.machine)
            told = {d.code for d in solid_faults(case.text, request)}
            if told <= {"solid-rounded", "solid-square"}:  # nothing of it is left out
                sound[stock].append(case)
    for stock, count in sorted(agreed.items()):
        print(f"{count} programs: {stock}" + (", agreed" if stock in KINDS else ""))
    for stock in stocks:
        for kind, make in KINDS[stock]:
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
