"""The staircase of an encoder as a picture: what it draws is what is read, and its figures hold."""

from math import floor, hypot
from pathlib import Path

import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st

from beamcam.cli import main
from beamcam.pictures.formats import to_svg
from beamcam.pictures.graphs import COUNTS, Study, encoder_scene
from beamcam.simulation.encoder import Encoder
from beamcam.simulation.trace import State, Trace, TraceAxis, TraceBuilder
from tests.conftest import examples
from tests.unit.pictures.drawings import Drawing, corners

SHIELD = Path(__file__).resolve().parents[3] / "samples" / "json" / "shield.json"
PLACES = st.tuples(st.floats(-20.0, 20.0), st.floats(-20.0, 20.0))


def through(places: list[tuple[float, float]]) -> Trace:
    builder = TraceBuilder([TraceAxis("X"), TraceAxis("Y")], places[0])
    for line, place in enumerate(places[1:], 1):
        builder.add([1.0], [place], (1.0, 1.0), line, State())
    return builder.trace()


def drawn(study: Study) -> Drawing:
    return Drawing(to_svg(encoder_scene(study)))


@settings(max_examples=examples(20))
@given(st.lists(PLACES, min_size=2, max_size=5))
def test_the_way_that_is_read_goes_from_count_to_count(places: list[tuple[float, float]]) -> None:
    encoder = Encoder(512, 65.0)
    study = Study("a.st", "0" * 64, "table", through(places), encoder)
    found = drawn(study)
    (frame,) = [corners(e) for e in found.all("frame")][:1]
    (left, top), _, (right, bottom), _ = frame
    counts = (right - left) / (2 * COUNTS)
    corner = study.trace.at([study.precision.worst_time_s])[0]
    raster = [x - floor(x) for x in corner / encoder.count]
    for x, y in corners(found.all("stair", "way")[0]):
        # In counts from the corner: the raster lies the corner's own fraction off.
        off = (x - (left + right) / 2) / counts, ((top + bottom) / 2 - y) / counts
        for value, fraction in zip(off, raster, strict=True):
            assert (value + fraction + 0.5) % 1.0 == pytest.approx(0.5, abs=2e-3)
    for x, y in corners(found.all("true", "way")[0]):
        assert left - 0.1 <= x <= right + 0.1
        assert top - 0.1 <= y <= bottom + 0.1
    assert to_svg(encoder_scene(study)) == to_svg(encoder_scene(study))


def test_the_corner_that_is_read_furthest_off_is_marked() -> None:
    encoder = Encoder(500, 50.0)  # counts of 0.1 mm
    trace = through([(0.0, 0.0), (5.02, 0.01), (5.02, 9.99), (1.05, 3.0)])
    study = Study("a.st", "0" * 64, "table", trace, encoder)
    found = drawn(study)
    a, b = corners(next(e for e in found.all("off") if e.tag.endswith("path")))
    counts = (corners(found.all("frame")[0])[2][0] - corners(found.all("frame")[0])[0][0]) / 16
    assert hypot(a[0] - b[0], a[1] - b[1]) / counts * 0.1 == pytest.approx(
        hypot(0.02, 0.09), abs=1e-3
    )
    assert study.precision.max_corner_error == pytest.approx(hypot(0.02, 0.09))
    assert {"0.1000 mm", "0.0922 mm, block 2", "0.0573 mm of 2 corners"} <= set(found.texts)
    assert {"X", "Y", "X, mm", "Y, mm", "time, s"} <= set(found.texts)
    assert found.count("stair", "curve") == found.count("true", "curve") == 2


def test_the_command_draws_the_study(tmp_path: Path) -> None:
    run = CliRunner().invoke
    program = str(tmp_path / "s.st")
    words = ["post", str(SHIELD), "--machine", "table-simotion", "-o", program]
    assert run(main, words).exit_code == 0
    starts = {".svg": b"<svg", ".png": b"\x89PNG", ".pdf": b"%PDF", ".html": b"<!doctype html>"}
    for suffix, start in starts.items():
        made = []
        for out in (tmp_path / f"a{suffix}", tmp_path / f"b{suffix}"):
            done = run(main, ["simulate", program, "--encoder", "512/65", "-o", str(out)])
            assert done.exit_code == 0, done.output
            made.append(out.read_bytes())
        assert made[0] == made[1]
        assert made[0].startswith(start)
    page = (tmp_path / "a.html").read_text(encoding="utf-8")
    assert "largest corner error" in page
    assert "http" not in page.replace("http-equiv", "").replace("http://www.w3.org/2000/svg", "")
    done = run(main, ["simulate", program, "-o", str(tmp_path / "a.svg")])
    assert done.exit_code == 2
    assert "expected --encoder" in done.output
