"""Programs written by hand for one small part, so that no emitter has a say in these tests."""

from collections.abc import Collection, Sequence

from beamcam.checks.bars import run, verify
from beamcam.checks.bars.ability import FeatureRef, may_be_missing
from beamcam.checks.bars.pieces import ends_of
from beamcam.checks.bars.stations import MachinedFeatures
from beamcam.checks.bars.targets import targets_of
from beamcam.checks.bars.tools import ToolCatalogue
from beamcam.errors import Source, VerifyError, errors_in
from beamcam.machine import Machine, load
from beamcam.machine.machine import drill_of, saw_of
from beamcam.model.part import EndCuts, Hole, Part, Profile

BEAM = load("beamline")
ANNEX = load("beamline-annex")
IPE200 = Profile("I", "IPE200", 200.0, 100.0, 8.5, 5.6, 12.0)
SOURCE = Source("P1.nc1", 1)


def interpret(text: str, machine: Machine, name: str = "program") -> MachinedFeatures:
    """The features that a program makes. Raises VerifyError if it is faulty by itself."""
    done = run(text, machine, None, name)
    if errors_in(done.diagnostics):
        raise VerifyError(done.diagnostics)
    return done.made


def skippable(
    parts: Sequence[Part], machine: Machine, names: Collection[str]
) -> frozenset[FeatureRef]:
    """The features that may be left out under the names that `--allow-skips` takes."""
    saw, tools = saw_of(machine), ToolCatalogue(machine, drill_of(machine))
    return frozenset(
        (p, f)
        for p, part in enumerate(parts)
        for f in may_be_missing(part, targets_of(part, ends_of(part, saw), tools), tools, names)
    )


def hole(
    face: str, x: float, y: float, diameter: float, depth: float | None = None, line: int = 30
) -> Hole:
    kind = "through" if depth is None else "blind"
    return Hole(face, x, y, diameter, Source("P1.nc1", line), depth, kind)  # type: ignore[arg-type]


def part(*holes: Hole, length: float = 2000.0, web: tuple[float, float] = (0.0, 0.0)) -> Part:
    return Part("P1", IPE200, length, SOURCE, cuts=EndCuts(*web), features=tuple(holes))


WEB_HOLE = hole("v", 300.0, 80.0, 22.0)
FLANGE_HOLES = (hole("o", 700.0, 30.0, 14.0, line=31), hole("u", 700.0, 30.0, 14.0, line=32))
PART = part(WEB_HOLE, *FLANGE_HOLES)

# The blade is 4.04 thick: the trim cut ends at bar x 20, so the part starts there. The drills
# stand 778.56 behind the saw. The web's surface lies 47.2 below the flange tips; a 22 mm drill has
# a point of 6.609 mm, a 14 mm one of 4.206.
PROGRAM = """\
% P1
N1 G90
N2 M44 K100 L200
N3 M43 K1
N4 G00 X17.98
N5 M42 K0 F41.667
N6 M40 K2 L22
N7 G00 X1098.56 Y20 Z-5
N8 G00 X1098.56 Y20 Z42.2
N9 M03 K362
N10 M08
N11 G01 X1098.56 Y20 Z61.409 F1.507
N12 G00 X1098.56 Y20 Z-5
N13 M09
N14 M05
N15 M40 K13 L14
N16 G00 X1498.56 Y-5 Z158.6
N17 M03 K568
N18 M08
N19 G01 X1498.56 Y14.706 Z158.6 F1.895
N20 G00 X1498.56 Y-5 Z158.6
N21 M09
N22 M05
N23 G00 X2022.02
N24 M42 K0 F41.667
N25 M30
%
"""


def edit(*changes: tuple[str, str], text: str = PROGRAM) -> str:
    """The program with pieces of text replaced, each of which has to stand in it once."""
    for old, new in changes:
        assert text.count(old) == 1, f"{old!r} stands {text.count(old)} times in the program"
        text = text.replace(old, new)
    return text


def messages(text: str, *parts: Part, machine: Machine = BEAM) -> list[str]:
    """What the read-back says, a line each."""
    return [str(said) for said in verify(text, parts or (PART,), machine, (), "P1.gcode")]
