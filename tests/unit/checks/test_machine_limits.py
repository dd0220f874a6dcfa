"""What the machine's file rules out is refused by the read-back, however it was planned.

The planner's own checks are silenced one by one, and the program goes through the pipeline.
"""

import random
import re
from contextlib import suppress

import pytest
from msgspec.structs import replace

from beamcam.checks.bars import verify
from beamcam.errors import PlanError, Severity, VerifyError
from beamcam.machine import Machine, load
from beamcam.model.part import EndCuts, Feature, Hole, Part, Profile, Slot
from beamcam.pipeline import parts_of, post, read_file
from beamcam.planning import beam
from beamcam.planning.operations import hole as hole_kind
from beamcam.planning.operations import slot, work
from beamcam.planning.operations.finished_part import FinishedPart
from beamcam.readers import read
from tests.conftest import GOLDEN, SAMPLES, examples
from tests.random_bars import random_bar
from tests.unit.checks.programs import BEAM, PROGRAM, SOURCE

IPE300 = Profile("I", "IPE300", 300.0, 150.0, 10.7, 7.1, 15.0)
IPE600 = Profile("I", "IPE600", 600.0, 220.0, 19.0, 12.0, 24.0)
UPN200 = Profile("U", "UPN200", 200.0, 75.0, 11.5, 8.5, 11.5)
ANGLE = Profile("L", "L100", 100.0, 100.0, 10.0, 10.0, 12.0)
BOX = Profile("M", "RHS200", 200.0, 100.0, 8.0, 8.0, 12.0)
PUSHER = load("beamline-pusher")


def part(*features: Feature, profile: Profile = IPE300, mitre: float = 0.0) -> Part:
    cuts = EndCuts(web_end=mitre)
    return Part("P1", profile, 3000.0, SOURCE, cuts=cuts, features=features)


def hole(
    face: str, x: float, y: float, d: float, depth: float | None = None, kind: str = ""
) -> Hole:
    kind = kind or ("through" if depth is None else "blind")
    return Hole(face, x, y, d, SOURCE, depth, kind)  # type: ignore[arg-type]


@pytest.fixture
def silent_planner(monkeypatch: pytest.MonkeyPatch) -> None:
    """A planner that asks for no steel round holes."""
    monkeypatch.setattr(FinishedPart, "judge", lambda *_: [])
    for module in (hole_kind, slot):
        monkeypatch.setattr(module, "refuse_place", lambda *_: None)
    monkeypatch.setattr(hole_kind, "judge_pairs", lambda *_: [])


def refused(made: Part, machine: Machine = BEAM) -> list[str]:
    """What the read-back says of a part that the planner takes."""
    try:
        post([made], machine, bar=6000.0)
    except PlanError as error:
        pytest.fail(f"the planner asks: {error}")
    except VerifyError as error:
        return [str(d).partition("error ")[2] for d in error.diagnostics]
    return []


STEEL: list[tuple[str, Part, str]] = [
    ("a flange hole over the web", part(hole("o", 500.0, 75.0, 18.0)),
     "verify-hole-steel: found the hole 18 on face o of P1 at x 500, y 75 in the wall from y 71.45 "
     "to 78.55; expected steel all round it"),
    ("a flange hole that touches the web", part(hole("u", 500.0, 65.0, 18.0)), "in the wall"),
    ("a flange hole of a channel over its web", part(hole("o", 500.0, 9.0, 14.0), profile=UPN200),
     "in the wall from y 0 to 8.5"),
    ("a hole in the flange's way", part(hole("v", 500.0, 16.0, 18.0)), "in the wall from y 0"),
    ("a blind hole in the flange's way", part(hole("v", 500.0, 16.0, 18.0, 3.0)), "in the wall"),
    ("two holes that overlap", part(hole("v", 500.0, 100.0, 18.0), hole("v", 510.0, 100.0, 14.0)),
     "verify-hole-steel: found the hole 14 on face v of P1 at x 510, y 100 10 mm from the hole 18; "
     "expected at least 16 mm between their middles"),
    ("two sizes near one place", part(hole("v", 500.0, 100.0, 18.0), hole("v", 503.0, 100.0, 22.0)),
     "3 mm from the hole 18"),
    ("a hole over the end", part(hole("v", 2995.0, 100.0, 18.0)), "4 mm beyond the end of the par"),
    ("a hole over the start", part(hole("v", 4.0, 100.0, 18.0)), "5 mm beyond the start"),
    ("a hole over the flange's edge", part(hole("o", 500.0, 144.0, 18.0)), "3 mm beyond the edg"),
    ("a hole in the wedge of a mitre", part(hole("v", 2920.0, 200.0, 18.0), mitre=30.0),
     "beyond the end of the part"),
]  # fmt: skip


@pytest.mark.usefixtures("silent_planner")
@pytest.mark.parametrize(("what", "made", "said"), STEEL, ids=[what for what, _, _ in STEEL])
def test_holes_without_steel_are_refused(what: str, made: Part, said: str) -> None:
    assert any(said in one for one in refused(made)), refused(made)


SLOT = Slot("v", 2990.0, 150.0, 18.0, 30.0, 0.0, 0.0, SOURCE)


@pytest.mark.usefixtures("silent_planner")
def test_a_slot_over_the_end_is_refused() -> None:
    assert any(
        "slot 48 x 18" in one and "beyond the end" in one for one in refused(part(SLOT), PUSHER)
    )


FINE = [
    part(hole("o", 500.0, 40.0, 18.0), hole("u", 500.0, 60.0, 18.0)),
    part(hole("v", 500.0, 100.0, 18.0), hole("v", 518.0, 100.0, 18.0)),
    part(hole("v", 500.0, 20.7, 18.0)),
    part(hole("o", 500.0, 40.0, 18.0, 4.0), hole("o", 600.0, 75.0, 18.0, 4.0)),
    part(hole("v", 2991.0, 100.0, 18.0), hole("v", 9.0, 100.0, 18.0)),
    part(hole("v", 500.0, 100.0, 18.0), hole("v", 500.0, 100.0, 26.0, 3.0)),
]


@pytest.mark.usefixtures("silent_planner")
@pytest.mark.parametrize("made", FINE)
def test_holes_that_touch_and_stepped_ones_are_none_of_them(made: Part) -> None:
    assert refused(made) == []


SECTIONS: list[tuple[str, Profile, Machine, str]] = [
    ("too high", replace(IPE600, height=1300.0), BEAM,
     "verify-stock: found a section of 1300 x 220 mm; expected at most 1010 x 500 mm (height x "
     "width) at the saw"),
    ("too wide", replace(IPE600, width=700.0), BEAM,
     "at most 1000 x 500 mm (height x width) at the drill"),
    ("of a code", ANGLE, load("beamline-annex"),
     "verify-stock: found a section of L; expected one of I, U"),
    ("a tube", BOX, BEAM, "verify-stock: found a section of M; expected one of I, U, L"),
]  # fmt: skip


@pytest.mark.parametrize(
    ("what", "profile", "machine", "said"), SECTIONS, ids=[what for what, *_ in SECTIONS]
)
def test_sections_that_the_machine_does_not_take(
    what: str, profile: Profile, machine: Machine, said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(beam, "refuse_stock", lambda *_: [])
    monkeypatch.setattr(work, "_reach_at", lambda *_: None)
    machine = replace(machine, sections={**machine.sections, profile.code: 9})
    assert any(said in one for one in refused(part(profile=profile), machine))


@pytest.mark.parametrize(
    ("profile", "mitre", "said"),
    [
        (IPE600, 55.0, "verify-saw-reach: found a cut of 55 degrees through a section of 600 x 220 "
         "mm; expected at most 500 x 500 mm (height x width), as the blade reaches at that angle"),
        (IPE600, 45.0, ""), (IPE300, 55.0, ""), (IPE600, -45.0, ""),
    ],
)  # fmt: skip
def test_a_turned_blade_reaches_less_far(
    profile: Profile, mitre: float, said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(work, "_reach_at", lambda *_: None)
    found = refused(part(profile=profile, mitre=mitre))
    assert found == [] if not said else said in found[0]


@pytest.mark.parametrize(
    ("section", "angle", "code"),
    [
        ("K220 L600", "K30", ""), ("K220 L1300", "K0", "verify-stock"),
        ("K700 L300", "K0", "verify-stock"), ("K220 L600", "K55", "verify-saw-reach"),
        ("K150 L300", "K55", ""),
    ],
)  # fmt: skip
def test_what_a_program_says_of_its_section_is_held_against_the_stations(
    section: str, angle: str, code: str
) -> None:
    """Without the parts too, of which nothing but the words of the program is known."""
    text = re.sub(r"M44 K\S+ L\S+", f"M44 {section}", PROGRAM)
    text = re.sub(r"M42 K\S+", f"M42 {angle}", text)
    found = {d.code for d in verify(text, (), BEAM) if d.severity is Severity.ERROR}
    assert (code in found) if code else not found & {"verify-stock", "verify-saw-reach"}


def test_a_tool_that_nobody_has_is_refused_without_the_parts_too() -> None:
    wrong = PROGRAM.replace("M40 K2 L22", "M40 K2 L22.2")
    said = "found a drill 22.2 chosen; expected a tool that the shop has, the nearest is 22"
    assert [d.message for d in verify(wrong, (), BEAM) if d.code == "verify-no-tool"] == [said]


@pytest.mark.parametrize(
    ("edit", "said"),
    [
        (("Z143.6", "Z113.6"), "over the wall at y 75"), (("Z143.6", "Z180"), "beyond the edge"),
        (("X858.56 Y0 ", "X858.56 Y60 "), "10 mm from the hole of 22"),
    ],
)  # fmt: skip
def test_holes_without_steel_are_refused_without_the_parts_too(
    edit: tuple[str, str], said: str
) -> None:
    text = post(parts_of([read_file(str(SAMPLES / "dstv" / "beam.nc1"))])[0], BEAM).text
    changed = text.replace(*edit)
    assert changed != text
    found = [d for d in verify(changed, (), BEAM) if d.code == "verify-hole-steel"]
    assert found
    assert all(said in d.message for d in found)


@pytest.mark.parametrize("line", ["beamline", "beamline-annex", "beamline-pusher"])
def test_no_hole_of_a_sound_program_is_without_steel(line: str) -> None:
    """Of random bars, each with holes, slots, taps and sinks; and of the golden files."""
    machine = load(line)
    texts = [path.read_text() for path in (GOLDEN / line).glob("*.gcode")]
    for seed in range(examples(64)):
        bars = random_bar(line, random.Random(f"steel {seed}"))
        files = [read(bar.file(f"R{n}").encode(), f"R{n}.nc1") for n, bar in enumerate(bars)]
        with suppress(PlanError):
            texts.append(post([f.parts[0] for f in files], machine, skips=("all",)).text)
    assert len(texts) > 10
    for text in texts:
        assert "verify-hole-steel" not in {d.code for d in verify(text, (), machine)}
