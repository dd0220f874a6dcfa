"""One file for each rule: it gives exactly its code, at its line, with its text filled in."""

from pathlib import Path

import pytest

from beamcam.errors import Severity
from beamcam.readers.dstv import read, rules
from tests.conftest import rules_of

#: What an option settles has no file of its own: test_ends.py.
RULES = [rule for rule in rules_of(rules) if rule.code != "dstv-cut-settled"]

FOLDER = Path(__file__).parents[4] / "samples" / "bad" / "dstv"

LINES = {
    "dstv-after-en": 35,
    "dstv-arc-radius": 33,
    "dstv-arc-stretched": 33,
    "dstv-before-st": 1,
    "dstv-bend-fields": 33,
    "dstv-bevel-angle": 27,
    "dstv-bevel-land": 27,
    "dstv-bevel-lost": 34,
    "dstv-block-repeated": 28,
    "dstv-block-unknown": 32,
    "dstv-camber-fields": 27,
    "dstv-circle-in-ik": 33,
    "dstv-circle-points": 33,
    "dstv-code-case": 32,
    "dstv-code-indent": 32,
    "dstv-code-zero": 32,
    "dstv-comment-inline": 33,
    "dstv-contour-area": 33,
    "dstv-contour-empty": 33,
    "dstv-contour-fields": 33,
    "dstv-contour-open": 30,
    "dstv-corner-weight": 16,
    "dstv-cut-angle": 18,
    "dstv-cut-missing": 18,
    "dstv-decimal-comma": 33,
    "dstv-direction": 27,
    "dstv-edge": 33,
    "dstv-edge-mixed": 27,
    "dstv-encoding": 6,
    "dstv-endplane-fields": 27,
    "dstv-endplane-overruled": 33,
    "dstv-face": 27,
    "dstv-face-case": 27,
    "dstv-face-assumed": 33,
    "dstv-header-blank": 19,
    "dstv-header-extra": 26,
    "dstv-header-number": 11,
    "dstv-header-short": 19,
    "dstv-height": 11,
    "dstv-height-contour": 11,
    "dstv-hole-angle": 33,
    "dstv-hole-diameter": 33,
    "dstv-hole-duplicate": 34,
    "dstv-hole-fields": 33,
    "dstv-hole-outside": 33,
    "dstv-hole-small": 33,
    "dstv-hole-through": 33,
    "dstv-indent": 8,
    "dstv-inches": 12,
    "dstv-length": 10,
    "dstv-length-contour": 10,
    "dstv-mark-elsewhere": 5,
    "dstv-name-sizes": 12,
    "dstv-no-en": 33,
    "dstv-no-marking": 33,
    "dstv-no-st": 1,
    "dstv-not-dstv": 1,
    "dstv-notch-corner": 29,
    "dstv-plane": 26,
    "dstv-plane-fields": 28,
    "dstv-profile-case": 9,
    "dstv-profile-code": 9,
    "dstv-quantity": 7,
    "dstv-quantity-form": 7,
    "dstv-repeated-point": 29,
    "dstv-row-lost": 26,
    "dstv-saw-length": 10,
    "dstv-second-st": 34,
    "dstv-section": 12,
    "dstv-section-code": 26,
    "dstv-section-fields": 28,
    "dstv-single-punch": 33,
    "dstv-slot-letter": 33,
    "dstv-slot-round": 33,
    "dstv-text-fields": 33,
    "dstv-lip-code": 10,
    "dstv-lip-name": 9,
    "dstv-tee-name": 12,
    "dstv-tee-outline": 12,
    "dstv-text-long": 2,
    "dstv-text-outside": 33,
    "dstv-tolerance-fields": 33,
    "dstv-unread": 2,
    "dstv-unrolled": 8,
    "dstv-weight": 16,
    "dstv-weight-section": 16,
}

#: Says how much of a refused file was not read, so it comes with the reason for that.
COMPANION = "dstv-unread"


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: rule.code)
def test_file_of_a_rule_gives_exactly_its_code(rule):
    path = FOLDER / f"{rule.code}.nc1"
    reading = read(path.read_bytes(), path.name)
    found = [d for d in reading.diagnostics if d.code != COMPANION or rule.code == COMPANION]
    if rule.code == COMPANION:
        found = [d for d in found if d.code == COMPANION]
    assert [(d.code, d.source.line, d.severity) for d in found] == [
        (rule.code, LINES[rule.code], rule.severity)
    ]
    assert str(found[0]).startswith(f"{path.name}:{LINES[rule.code]}: {rule.severity.value} ")
    assert "{" not in found[0].message.replace("{...}", "")
    assert reading.refused == (rule.severity is Severity.ERROR or rule.code == COMPANION)


def test_every_rule_has_a_file_and_every_file_a_rule():
    codes = [rule.code for rule in RULES]
    assert len(set(codes)) == len(codes)
    assert {path.stem for path in FOLDER.glob("*.nc1")} == set(codes) == set(LINES)


def test_rules_say_why():
    for rule in RULES:
        assert rule.code.startswith("dstv-")
        assert rule.reason.endswith(".")
        assert (
            "expected" in rule.message
            or rule.severity is not Severity.ERROR
            or "cannot" in (rule.message)
            or rule.code == "dstv-cut-angle"
        )
