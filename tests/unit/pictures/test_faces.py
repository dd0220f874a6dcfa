"""Pictures of faces, held against the solid: every hole is where steel is missing.

A chiral part has one hole on each face, off every middle, so that whatever is drawn mirrored or
upside down has a hole where the solid has steel. How paper is folded about a bar stands here by
itself: a view's lower edge on the paper, and the way up from it.
"""

import io
from pathlib import Path
from xml.etree import ElementTree

import ezdxf
import pytest

from beamcam.errors import Source
from beamcam.machine import load
from beamcam.model.part import Hole, Part, Profile
from beamcam.pictures import ReadProgram
from beamcam.pictures.comparison import compared_parts
from beamcam.pictures.formats import to_svg
from beamcam.pictures.part import part_scene
from beamcam.pictures.program import program_scene
from beamcam.pictures.scene import Scene
from beamcam.pipeline import post
from beamcam.solid.kernel import kernel
from beamcam.solid.part_solid import part_solid
from beamcam.writers.faces_dxf import write
from tests.test_pictures_of_docs import DRAW
from tests.unit.pictures.drawings import Drawing, corners

DIAMETER, EXAMPLE, HOLES, LENGTH = DRAW.DIAMETER, DRAW.EXAMPLE, DRAW.HOLES, DRAW.LENGTH
PAGE = Path(__file__).resolve().parents[3] / "docs" / "pictures" / "faces.svg"
HERE = Source("chiral.nc1", 1)
SECTIONS = (
    EXAMPLE,
    Profile("I", "IPE300", 300.0, 150.0, 10.7, 7.1, 15.0),
    Profile("M", "RHS140x90", 140.0, 90.0, 6.0, 6.0, 9.0),
)

Place = tuple[float, float]  #: along the paper from the start, up from a view's lower edge


def chiral(profile: Profile, faces: str = "vouh") -> Part:
    """A part of which no face is its own mirror image."""
    holes = tuple(
        Hole(face, HOLES[face][0], 0.3 * profile.face_width(face), DIAMETER, HERE, depth=None)
        for face in faces
    )
    return Part("CH1", profile, LENGTH, HERE, features=holes)


def folded(profile: Profile, face: str, place: Place) -> tuple[float, float, float]:
    """Where in the section's axes a place of a view is, on the middle of its wall.

    Z counts from the h side to the front; o unfolds upwards from the front's upper edge and u
    downwards from its lower one, so that the edge beside v is at Z = width on both.
    """
    along, up = place
    h, b, t, s = profile.height, profile.width, profile.flange_thickness, profile.web_thickness or 0
    web = {"I": b / 2, "U": s / 2, "M": b - s / 2}[profile.code]
    back = s / 2 if profile.code == "M" else web
    return {
        "v": (along, up, web), "h": (along, up, back),
        "o": (along, h - t / 2, b - up), "u": (along, t / 2, up),
    }[face]  # fmt: skip


def is_hole(part: Part, at: tuple[float, float, float], face: str) -> bool:
    """Whether small cubes in the wall, at the centre and about it, find no steel."""
    m, solid = kernel(), part_solid(part)
    r = DIAMETER / 2 - 1.5
    for a, b in ((r, 0), (-r, 0), (0, r), (0, -r), (0, 0)):
        where = (at[0] + a, at[1] + b, at[2]) if face in "vh" else (at[0] + a, at[1], at[2] + b)
        needle = m.Manifold.cube((1.0, 1.0, 1.0), True).translate(where)
        if (solid ^ needle).volume() > 1e-6:
            return False
    return True


def by_view(found: Drawing) -> list[tuple[int, Place]]:
    """Holes with the number of their view from the top of the paper down, in mm of the part."""
    boxes = sorted(
        (min(y for _, y in box), max(y for _, y in box), min(x for x, _ in box),
         max(x for x, _ in box))
        for box in map(corners, found.all("face") or found.all("stock-outline"))
    )  # fmt: skip
    scale = (boxes[0][3] - boxes[0][2]) / LENGTH
    holes = []
    for e in found.all("hole") or found.all("hole-of"):
        x, y = float(e.get("cx", "nan")), float(e.get("cy", "nan"))
        (k,) = (k for k, (top, bottom, *_) in enumerate(boxes) if top < y < bottom)
        holes.append((k, ((x - boxes[k][2]) / scale, (boxes[k][1] - y) / scale)))
    return holes


def test_the_shipped_picture_shows_each_hole_where_the_solid_has_it() -> None:
    found = by_view(Drawing(PAGE.read_text(encoding="utf-8")))
    assert [k for k, _ in found] == [0, 1, 2, 3]
    faces = "hovu"
    holes = tuple(Hole(f, *HOLES[f], DIAMETER, HERE) for f in faces)
    part = Part("P", EXAMPLE, LENGTH, HERE, features=holes)
    for k, place in found:
        face = faces[k]
        assert is_hole(part, folded(EXAMPLE, face, place), face), face
        width = EXAMPLE.face_width(face)
        mirrored = folded(EXAMPLE, face, (place[0], width - place[1]))
        assert not is_hole(part, mirrored, face), face


def test_the_shipped_picture_says_what_it_shows() -> None:
    root = ElementTree.parse(PAGE).getroot()
    texts = [e.text or "" for e in root.iter() if e.tag.endswith("text")]
    assert all(texts.count(face) == 1 for face in "vouh")
    assert texts.count("x") == texts.count("y") == 4
    for face, seen, edge in (
        ("h", "from behind, drawn through the web", "lower"), ("o", "from above", "upper"),
        ("v", "from the front", "lower"), ("u", "from below", "lower"),
    ):  # fmt: skip
        (title,) = (t for t in texts if t.startswith(f"{face}   "))
        assert seen in title
        assert title.endswith(f"y = 0 is the {edge} edge")


PICTURES = [(profile, kind) for profile in SECTIONS for kind in ("part", "comparison")]
PICTURES += [(profile, "program") for profile in SECTIONS[:2]]  #: the line takes no tubes


@pytest.mark.parametrize(("profile", "kind"), PICTURES, ids=lambda one: getattr(one, "code", one))
def test_pictures_show_each_hole_where_the_solid_has_it(profile: Profile, kind: str) -> None:
    faces = "vou" if kind == "program" else "vouh"
    part = chiral(profile, faces)
    order = [f for f in "hovu" if f in faces]
    if kind == "part":
        scene = part_scene(part)
    elif kind == "comparison":
        scene = compared_parts(part, part).scene
    else:
        scene = _program(part)
    found = by_view(Drawing(_with_views(to_svg(scene))))
    assert len(found) == len(faces)
    for k, place in found:
        face = order[k]
        assert is_hole(part, folded(profile, face, place), face), face
        mirrored = (place[0], profile.face_width(face) - place[1])
        assert not is_hole(part, folded(profile, face, mirrored), face), face


def _program(part: Part) -> Scene:
    machine = load("beamline")
    text = post((part,), machine).text
    return program_scene(ReadProgram(text.encode(), machine, "ch.gcode", "", (part,)))


def _with_views(svg: str) -> str:
    """A bar's picture has its part as a piece; it stands for the view."""
    return svg.replace('class="part piece"', 'class="face piece"')


@pytest.mark.parametrize("profile", SECTIONS, ids=lambda p: p.code)
def test_the_drawing_of_the_faces_lies_as_they_unfold(profile: Profile) -> None:
    part = chiral(profile)
    space = ezdxf.read(io.StringIO(write(part))).modelspace()
    for face in "vouh":
        lines = [e for e in space.query("LINE") if e.dxf.layer == f"FACE_{face}"]
        low = min(p.y for e in lines for p in (e.dxf.start, e.dxf.end))
        (hole,) = (e for e in space.query("CIRCLE") if e.dxf.layer == f"FACE_{face}_HOLES")
        place = (hole.dxf.center.x, hole.dxf.center.y - low)
        assert is_hole(part, folded(profile, face, place), face), face
        (label,) = (e.dxf.text for e in space.query("TEXT") if e.dxf.layer == f"FACE_{face}_LABEL")
        assert "y = 0 is the" in label
