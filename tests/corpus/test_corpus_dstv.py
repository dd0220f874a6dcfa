"""Real DSTV files: what the reader finds in them is what was counted by other means."""

import json
from collections import Counter
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from beamcam.errors import Severity
from beamcam.geometry.curves import Arc
from beamcam.model.part import Contour, Part
from beamcam.readers.dstv import read, read_with_account
from tests.conftest import CORPUS

FOLDER = CORPUS / "dstv"
TRUTH: dict[str, dict[str, Any]] = (
    json.loads((FOLDER / "truth.json").read_text()) if FOLDER.is_dir() else {}
)

pytestmark = pytest.mark.third_party

VALID = [name for name, truth in TRUTH.items() if truth["valid"]]
INVALID = [name for name, truth in TRUTH.items() if not truth["valid"]]
CODES = {("outer", "cut"): "AK", ("inner", "cut"): "IK"}


def part_of(name: str) -> Part:
    reading = read((FOLDER / name).read_bytes(), Path(name).name)
    assert not reading.refused, reading.diagnostics
    (part,) = reading.parts
    return part


def summary(contour: Contour) -> list[Any]:
    """A contour as the truth tells it, without the sign of its area."""
    corners = [curve.start for curve in contour.curves] + [contour.curves[-1].end]
    area = sum(x0 * y1 - x1 * y0 for (x0, y0), (x1, y1) in pairwise(corners))
    code = CODES.get((contour.kind, contour.process), "PU")
    return [
        "KO" if contour.process == "punch" else code,
        contour.face,
        len(contour.curves) + 1 + len(contour.notches),
        contour.closed,
        sum(isinstance(curve, Arc) for curve in contour.curves),
        len(contour.notches),
        len({bevel.curve for bevel in contour.bevels}),
        pytest.approx(abs(area / 2) if contour.closed else 0, abs=0.06),
    ]


@pytest.mark.parametrize("name", VALID)
def test_part_is_as_counted(name: str) -> None:
    part, truth = part_of(name), TRUTH[name]
    p = part.profile
    assert part.mark == truth["piece"]
    assert p.code == truth["profile_code"]
    assert (part.length, part.saw_length) == (truth["length"], truth["saw_length"])
    assert part.quantity == truth["quantity"]
    dims = [p.height, p.width, p.flange_thickness, p.web_thickness, p.radius]
    assert dims == truth["dims"]
    cuts = part.cuts
    assert [cuts.web_start, cuts.web_end, cuts.flange_start, cuts.flange_end] == truth["cuts"]
    rows = Counter(f.face for f in (*part.holes, *part.slots))
    assert rows == truth["holes_by_face"]
    kinds = Counter(hole.kind for hole in part.holes)
    assert len(list(part.slots)) == truth["slots"]
    assert kinds["mark"] == truth["marks"]
    assert kinds["countersink"] == truth["countersinks"]
    assert kinds["thread"] + kinds["left-thread"] == truth["threads"]
    assert [text.text for text in part.texts] == truth["si"]
    expected = [[*row[:7], abs(row[7]) if row[3] else 0.0] for row in truth["contours"]]
    assert [summary(contour) for contour in part.contours] == expected


@pytest.mark.parametrize("name", INVALID)
def test_invalid_file_is_refused_with_a_line(name: str) -> None:
    reading = read((FOLDER / name).read_bytes(), Path(name).name)
    errors = [d for d in reading.diagnostics if d.severity is Severity.ERROR]
    assert errors
    assert all(d.source.line is not None and d.code.startswith("dstv-") for d in errors)


@pytest.mark.parametrize("name", sorted(TRUTH))
def test_no_line_is_lost(name: str) -> None:
    _, account = read_with_account((FOLDER / name).read_bytes(), Path(name).name)
    assert account.lost == []
