"""PNG and PDF of the same scenes, and the profile's axes."""

import io
import re
import sys
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from msgspec.structs import replace
from PIL import Image

from beamcam.errors import PictureError
from beamcam.motion.velocity_profile import profile_to_velocity
from beamcam.pictures.formats import dashes, largest, to_pdf, to_png, to_svg
from beamcam.pictures.graphs import profile_scene, ticks
from beamcam.pictures.scene import STYLES, Circle, Polyline, Scene, Text, css
from beamcam.reports.velocity_profile import MM_S, RPM, VelocityUnit
from tests.runs import call
from tests.unit.pictures.drawings import Drawing, corners

GUIDE = profile_to_velocity(1000.0, 100.0, 50.0)
SCENE = Scene(
    "all", "one of each", 200.0, 100.0,
    (
        Polyline("face", ((10, 10), (150, 10), (150, 90), (10, 90)), True),
        Circle("hole", (40, 40), 10.0), Polyline("rapid", ((20, 20), (120, 80))),
        Text("label", (60, 30), "Łä — text", turn_deg=90.0), Text("heading", (60, 60), "bold"),
    ),
)  # fmt: skip


def test_a_png_is_a_picture_of_its_size() -> None:
    data = to_png(SCENE)
    image = Image.open(io.BytesIO(data)).convert("RGB")
    assert image.size == (200, 100)
    assert image.getpixel((198, 50)) == (255, 255, 255)
    assert image.getpixel((100, 10)) != (255, 255, 255)
    assert image.getpixel((140, 20)) == (244, 246, 249)
    assert len(image.getcolors(100_000)) > 20  # letters and smooth lines
    assert data == to_png(SCENE)


def test_a_pdf_has_a_page_for_each_scene_and_the_same_bytes() -> None:
    data = to_pdf([SCENE, SCENE])
    assert data.startswith(b"%PDF")
    assert len(re.findall(rb"/Type /Page\b", data)) == 2
    assert data == to_pdf([SCENE, SCENE])


@pytest.mark.parametrize(("paper", "wide"), [("a4", 842), ("a3", 1191)])
def test_a_pdf_is_a4_or_a3_and_filled(paper: Any, wide: int) -> None:
    """A wide picture lies on its side; on A3 all of it is larger."""
    scene = replace(SCENE, width=1000.0, height=600.0)
    data = to_pdf([scene], paper)
    (box,) = {tuple(round(float(v)) for v in found.split())
              for found in re.findall(rb"/MediaBox \[ ?([\d. ]+)\]", data)}  # fmt: skip
    assert box[2] == wide
    assert largest(paper) * 1000.0 == pytest.approx(750.0 * wide / 842, rel=0.001)


@pytest.mark.parametrize(("module", "draw"), [("PIL", to_png), ("reportlab.pdfgen.canvas", to_pdf)])
def test_a_library_that_is_missing_is_named(
    module: str, draw: object, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(PictureError) as error:
        draw(SCENE if draw is to_png else [SCENE])  # type: ignore[operator]
    assert error.value.diagnostics[0].code == "picture-needs"
    assert "pip install beamcam[pictures]" in str(error.value)


@pytest.mark.parametrize(("unit", "names"), [
    (MM_S, ["position, mm", "velocity, mm/s", "acceleration, mm/s/s"]),
    (RPM, ["position, revolutions", "velocity, rpm", "acceleration, rpm/s"]),
])  # fmt: skip
def test_a_profile_has_axes_with_numbers_and_units(unit: object, names: list[str]) -> None:
    scene = profile_scene(GUIDE, unit)  # type: ignore[arg-type]
    found = Drawing(to_svg(scene))
    assert found.count("curve") == 3
    assert {*names, "time, s", "1000", "0", "100"} <= set(found.texts)
    assert found.count("tick-label") >= 3 * 3 + 5
    frames = [corners(e) for e in found.all("frame")]
    for frame, curve in zip(frames, found.all("curve"), strict=True):
        (left, top), _, (right, bottom), _ = frame
        for x, y in corners(curve):
            assert left - 0.02 <= x <= right + 0.02
            assert top - 0.02 <= y <= bottom + 0.02
    picture = Image.open(io.BytesIO(to_png(scene))).convert("L")
    # Numbers stand left of the first axis: there is ink between the edge and the frame.
    strip = picture.crop((0, round(frames[0][0][1]), round(frames[0][0][0]) - 8, 220))
    assert strip.getextrema()[0] < 120


@pytest.mark.parametrize("unit", [MM_S, RPM])
def test_all_of_a_profile_is_on_the_png_too(unit: VelocityUnit) -> None:
    """Each text and each line of the SVG has ink at its place."""
    scene = profile_scene(GUIDE, unit)
    picture = Image.open(io.BytesIO(to_png(scene))).convert("L")
    for shape in scene.shapes:
        if isinstance(shape, Text):
            x, y = shape.at
            wide = {"start": (0, 12), "middle": (-4, 4), "end": (-12, 0)}[shape.anchor]
            box = (x + wide[0], y - shape.size * 0.8, x + wide[1], y + 1.0)
        elif isinstance(shape, Polyline):
            (x, y) = shape.points[len(shape.points) // 2]
            box = (x - 1.0, y - 1.0, x + 2.0, y + 2.0)
        ink = picture.crop(tuple(round(v) for v in box)).getextrema()[0]
        assert ink < 235, shape


@pytest.mark.parametrize("suffix", [".png", ".pdf"])
def test_the_commands_say_which_extra_is_missing(
    suffix: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for module in ("PIL", "reportlab", "reportlab.pdfgen.canvas"):
        monkeypatch.setitem(sys.modules, module, None)
    out = tmp_path / f"a{suffix}"
    job = "tests/golden/beamline/beam.gcode"
    for words in (["plot", "samples/dstv/channel.nc1"], ["plot", job],
                  ["profile", "--velocity", "9", "--time", "2"],
                  ["simulate", job, "--encoder", "512/65"],
                  ["diff", "samples/dstv/channel.nc1", "samples/dstv/tie.nc1"]):  # fmt: skip
        done = call(*words, "-o", out, status=1)
        assert "pip install beamcam[pictures]" in done.output
        assert not out.exists()


@pytest.mark.parametrize(
    ("low", "high", "expected"),
    [(0.0, 100.0, [0, 20, 40, 60, 80, 100]), (-3.0, 3.0, [-2, 0, 2]), (2.0, 2.0, [2])],
)
def test_ticks_are_round(low: float, high: float, expected: list[float]) -> None:
    assert ticks(low, high) == pytest.approx(expected)


def test_dashes_cover_what_the_pattern_says() -> None:
    found = list(dashes([(0.0, 0.0), (10.0, 0.0), (10.0, 10.0)], (4.0, 2.0)))
    length = sum(abs(b[0] - a[0]) + abs(b[1] - a[1]) for run in found for a, b in pairwise(run))
    assert length == pytest.approx(4 + 4 + 4 + 2)
    assert found[1] == [(6.0, 0.0), (10.0, 0.0)]


def test_each_style_has_a_rule_in_the_light_and_in_the_dark() -> None:
    for text in (css(), css("@", dark=True)):
        assert all(f".{name}{{fill:" in text for name in STYLES)


def contrast(one: str, two: str) -> float:
    """The contrast ratio of two colours. Source: WCAG 2.2, relative luminance."""

    def light(colour: str) -> float:
        parts = [int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)]
        r, g, b = (v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4 for v in parts)
        return 0.2126 * r + 0.7152 * g + 0.0722 * b

    a, b = sorted((light(one), light(two)))
    return (b + 0.05) / (a + 0.05)


def test_texts_and_lines_can_be_told_from_the_paper() -> None:
    paper = STYLES["paper"]
    assert paper.fill is not None
    assert paper.dark_fill is not None
    for name, style in STYLES.items():
        if name in ("paper", "grid", "lead"):
            continue
        ink, dark = style.stroke or style.fill, style.dark_stroke or style.dark_fill
        need = 4.5 if style.stroke is None else 2.8
        assert contrast(str(ink), paper.fill) >= need, name
        assert contrast(str(dark), paper.dark_fill) >= need, name


def test_the_command_writes_each_format(tmp_path: Path) -> None:
    part = "samples/dstv/channel.nc1"
    for suffix, start in ((".svg", b"<svg"), (".png", b"\x89PNG"), (".pdf", b"%PDF")):
        out = tmp_path / f"part{suffix}"
        call("plot", part, "-o", out, status=0)
        assert out.read_bytes().startswith(start)
    to_screen = call("plot", part, "-o", "-")
    assert to_screen.stdout_bytes == (tmp_path / "part.svg").read_bytes()


def test_the_command_draws_a_bar_and_programs(tmp_path: Path) -> None:
    part, tie = "samples/dstv/channel.nc1", "samples/dstv/tie.nc1"
    bar, job, again = (str(tmp_path / n) for n in ("bar.svg", "job.gcode", "job.svg"))
    assert call("plot", part, tie, "-o", bar).exit_code == 0
    assert call("post", part, tie, "-o", job).exit_code == 0
    assert call("plot", job, "-o", again).exit_code == 0
    both = [Drawing(Path(path).read_text(encoding="utf-8")) for path in (bar, again)]
    assert both[0].count("hole") == both[1].count("hole") > 10
    assert "parts: C1, T1" in both[0].texts
    assert "parts: part 1, part 2" in both[1].texts


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["samples/dstv/channel.nc1", "-o", "x.gif"], "expected a name in .svg, .png, .pdf"),
        (["samples/ifc/beam_openings.ifc", "samples/dstv/tie.nc1", "--show", "part", "-o", "x.svg"],
         "expected one, or a .pdf of many pages"),
        (["tests/golden/beamline/beam.gcode", "samples/dstv/tie.nc1", "-o", "x.svg"],
         "expected it alone"),
    ],
)  # fmt: skip
def test_wrong_usage_is_told(words: list[str], said: str) -> None:
    done = call("plot", *words, status=2)
    assert said in " ".join(done.output.split())
