"""Bars machined as solids: sound programs agree, and every lie of a program is seen."""

import re

import pytest
from msgspec.structs import replace

from beamcam.errors import BeamcamError
from beamcam.geometry.curves import Line
from beamcam.machine import load
from beamcam.model.part import Contour, EndCuts, Hole, Part, Profile
from beamcam.model.request import Request
from beamcam.pipeline import parts_of, post, read_file
from beamcam.solid.opinion import solid_faults
from beamcam.solid.part_solid import part_solid
from tests.conftest import ROOT, sampled
from tests.unit.solid.programs import ODD, SRC, codes, mirrored, posted, sample, told

MACHINES = ("beamline", "beamline-annex", "beamline-pusher")
BARS = [
    *[(name, machine) for name in ("beam", "channel", "strut", "tie", "marked")
      for machine in MACHINES],
    ("tube", "beamline-pusher"), ("beam beam", "beamline"), ("strut strut", "beamline-pusher"),
    ("tie channel tie", "beamline-annex"),
]  # fmt: skip


@pytest.mark.parametrize(("names", "machine"), sampled(BARS, 2))
def test_sound_programs_agree(names: str, machine: str) -> None:
    parts = sample(*names.split())
    assert codes(posted(parts, machine), parts, machine, skips=("all",)) == []


@pytest.mark.parametrize("name", sampled(["header", "trimmer", "coped"], 3))
def test_the_rest_of_a_bar_is_not_taken_for_a_part_whose_copes_are_left_out(name: str) -> None:
    parts, _ = parts_of([read_file(str(ROOT / "samples" / "coping" / f"{name}.nc1"))])
    assert codes(posted(parts, "beamline"), parts, "beamline", skips=("all",)) == []


@pytest.mark.parametrize("machine", ["beamline", "beamline-pusher"])
def test_the_odd_part_agrees(machine: str) -> None:
    assert codes(posted((ODD,), machine), (ODD,), machine) == []


@pytest.mark.parametrize("machine", ["beamline", "beamline-pusher"])
def test_a_turned_part_agrees(machine: str) -> None:
    text = post([ODD], load(machine), turn=True).text
    assert codes(text, (ODD,), machine) == []


def test_skew_ends_that_only_outlines_have() -> None:
    """Flange angles of a tube, by the outlines of its upper and lower wall."""
    profile = Profile("M", "SHS100X6", 100.0, 100.0, 6.0, 6.0)
    skew = [(80.0, 0.0), (1000.0, 0.0), (950.0, 100.0), (0.0, 100.0)]
    chain = tuple(map(Line, skew, [*skew[1:], skew[0]]))
    outlines = tuple(Contour(face, "outer", chain, SRC) for face in "ou")
    holes = (Hole("o", 300.0, 40.0, 18.0, SRC), Hole("v", 600.0, 40.0, 14.0, SRC))
    part = Part("T", profile, 1000.0, SRC, features=(*outlines, *holes))
    body = part_solid(part)
    assert body.volume() < part_solid(replace(part, features=holes)).volume() - 50_000
    assert codes(posted((part,), "beamline-pusher"), (part,), "beamline-pusher") == []


def without_stroke(text: str, number: int) -> str:
    """A program without its stroke of this number, from the choice of its spindle to its stop."""
    strokes = re.findall(r"(?ms)^N\d+ M40 .*?^N\d+ M05$\n", text)
    return text.replace(strokes[number], "")


def test_a_missing_hole_is_named_by_its_place() -> None:
    (part,) = parts = sample("tie")
    text = without_stroke(posted(parts), 0)
    hole = min(part.holes, key=lambda h: (h.x, h.y))
    said = told(text, parts)
    assert said.count("solid-extra") == 1
    assert f"mm3 on face v at x {hole.x:.1f}, y {hole.y:.1f}" in said


def test_a_hole_on_another_face() -> None:
    other = replace(ODD, features=tuple(
        replace(f, face="u", y=50.0) if f.x == 80.0 else f for f in ODD.holes))  # fmt: skip
    said = told(posted((other,)), (ODD,))
    assert "solid-missing" in said
    assert "on face u at x 80.0" in said
    assert "solid-extra" in said
    assert "on face v at x 80.0, y 70.0" in said


@pytest.mark.parametrize(("deeper", "code"), [(2.0, "solid-missing"), (-2.0, "solid-extra")])
def test_a_blind_hole_of_another_depth(deeper: float, code: str) -> None:
    features = tuple(replace(f, depth=f.depth and f.depth + deeper) for f in ODD.holes)
    assert codes(posted((replace(ODD, features=features),)), (ODD,)) == [code]


def test_a_drill_that_does_not_get_through() -> None:
    (part,) = sample("tie")
    text = posted((part,))
    short = text.replace("Z82.408", "Z79.000", 1)  # its point 5.4 is through, the drill is not
    assert short != text
    said = told(short, (part,))
    assert "1 lump(s)" in said
    assert codes(short, (part,)) == ["solid-extra"]


@pytest.mark.parametrize("off", sampled([-0.5, 3.0, 0.5], 2))
def test_a_hole_that_is_moved(off: float) -> None:
    moved = tuple(replace(f, x=f.x + off * (f.x == 200.0)) for f in ODD.holes)
    said = codes(posted((replace(ODD, features=moved),)), (ODD,))
    assert said == ["solid-missing", "solid-extra"]


def test_a_hole_of_another_size() -> None:
    for size, code in ((20.0, "solid-missing"), (16.0, "solid-extra")):
        other = tuple(replace(f, diameter=size if f.x == 80.0 else f.diameter) for f in ODD.holes)
        assert codes(posted((replace(ODD, features=other),)), (ODD,)) == [code]


def test_the_mirror_image_is_another_part() -> None:
    text = posted((mirrored(ODD),))
    assert codes(text, (ODD,)) == ["solid-hand"]
    assert codes(posted((ODD,)), (mirrored(ODD),)) == ["solid-hand"]


@pytest.mark.parametrize("off", sampled([-1.0, 40.0, 1.0], 2))
def test_another_length(off: float) -> None:
    said = codes(posted((replace(ODD, length=ODD.length + off),)), (ODD,))
    assert said[0] == "solid-size"


def test_another_mitre() -> None:
    said = codes(posted((replace(ODD, cuts=EndCuts(web_end=-20.0)),)), (ODD,))
    assert {"solid-missing", "solid-extra"} <= {*said}


def test_the_kerf_on_the_wrong_side() -> None:
    """The last cut half a kerf too early, where its middle should be the part's end."""
    text = posted((ODD,))
    cuts = re.findall(r"X(\S+)\nN\d+ M42", text)
    wrong = text.replace(f"X{cuts[-1]}\n", f"X{float(cuts[-1]) - 4.04:.3f}\n")
    assert wrong != text
    assert "solid-size" in codes(wrong, (ODD,))


def test_pieces_are_counted() -> None:
    parts = sample("tie", "tie")
    text = posted(parts)
    assert codes(text, parts[:1]) == ["solid-pieces"]
    said = codes(posted(parts[:1]), parts)
    assert "solid-size" in said or "solid-pieces" in said
    for asked, expected in ((2, 0), (1, 1)):
        request = Request(parts[:1], load("beamline"), quantity=asked)
        assert len(solid_faults(text, request)) == expected


def test_the_order_of_the_bar_does_not_matter() -> None:
    parts = sample("tie", "channel")
    assert codes(posted(parts), parts[::-1], skips=("all",)) == []


def test_what_may_be_left_out_is_told() -> None:
    (part,) = sample("tie")
    more = replace(part, features=(*part.features, Hole("h", 160.0, 100.0, 18.0, SRC)))
    fewer = posted((part,))
    assert codes(fewer, (more,)) == ["solid-extra"]
    (said,) = solid_faults(fewer, Request((more,), load("beamline"), ("face",)))
    assert said.code == "solid-left-out"
    assert "of a hole on face h left on piece 1" in said.message
    # Holes may not be left out where only slots may.
    assert codes(fewer, (more,), skips=("slot",)) == ["solid-extra"]


def test_the_end_of_the_bar_is_an_end_where_it_is_known() -> None:
    (part,) = sample("tie")
    text = posted((part,))
    cuts = re.findall(r"N\d+ G00 X\S+\nN\d+ M42 K\S+ F\S+\n", text)
    first_only = text.replace(cuts[-1], "")
    assert codes(first_only, (part,)) != []
    assert codes(first_only, (part,), bar=20.0 + part.length) == []


def test_a_section_without_its_figures_says_so() -> None:
    (part,) = sample("tie")
    thin = replace(part, profile=replace(part.profile, web_thickness=None))
    assert codes(posted((part,)), (thin,)) == ["solid-none"]


def test_other_machines_have_no_solid() -> None:
    (part,) = sample("gusset")
    (said,) = solid_faults("", Request((part,), load("laser-stepper")))
    assert said.code == "solid-machine"
    with pytest.raises(BeamcamError):
        raise BeamcamError(said)
