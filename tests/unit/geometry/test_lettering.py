"""The letters, and how a text is spelled in them."""

import string
from unicodedata import name

import pytest
from hypothesis import given
from hypothesis import strategies as st

from beamcam.geometry.lettering import _font, body_share, glyph_of, spelled

PLAIN = string.ascii_letters + string.digits + string.punctuation
ACCENTED = (
    "ÄÖÜäöüßÀÁÂÃÅÇÈÉÊËÌÍÎÏÑÒÓÔÕØÙÚÛÝàáâãåæçèéêëìíîïñòóôõøùúûýÿÆŒœ"
    "ŁłĐđŚśŹźŻżĄąĘęČčŠšŽžŘřŮůŐőŰűĞğŞşİıȘșȚț"
)
SIGNS = "°±×·µ²³€"


def test_a_character_has_its_strokes() -> None:
    for sign in PLAIN + ACCENTED + SIGNS:
        glyph = glyph_of(sign)
        assert glyph is not None, sign
        assert glyph.advance > 0.0
        assert all(len(stroke) >= 2 for stroke in glyph.strokes)
        xs = [x for stroke in glyph.strokes for x, _ in stroke]
        ys = [y for stroke in glyph.strokes for _, y in stroke]
        assert -0.2 <= min(xs) <= max(xs) <= glyph.advance + 0.2, sign
        assert -0.5 <= min(ys) <= max(ys) <= 1.6, sign


@pytest.mark.parametrize("sign", "ABHXZ0179")
def test_a_capital_is_as_high_as_its_height(sign: str) -> None:
    glyph = glyph_of(sign)
    assert glyph is not None
    ys = [y for stroke in glyph.strokes for _, y in stroke]
    assert (min(ys), max(ys)) == (0.0, 1.0)


def test_no_stroke_passes_a_place_twice() -> None:
    """A torch that marks would burn there twice, and a sheet's overlaps are taken away."""
    for sign in PLAIN + ACCENTED + SIGNS:
        glyph = glyph_of(sign)
        assert glyph is not None
        pieces = list(glyph.segments)
        for k, one in enumerate(pieces):
            assert not any(overlap(one, other) for other in pieces[:k]), sign


def overlap(one: tuple[tuple[float, float], ...], other: tuple[tuple[float, float], ...]) -> bool:
    """Whether two straight pieces share more than a point."""
    (ax, ay), (bx, by) = one
    ux, uy = bx - ax, by - ay
    length2 = ux * ux + uy * uy
    if any(abs(ux * (y - ay) - uy * (x - ax)) > 1e-6 * length2**0.5 for x, y in other):
        return False
    low, high = sorted(((x - ax) * ux + (y - ay) * uy) / length2 for x, y in other)
    return min(1.0, high) - max(0.0, low) > 1e-6


def test_an_accented_letter_is_its_base_and_more() -> None:
    plain, accented = glyph_of("A"), glyph_of("Ä")
    assert plain is not None
    assert accented is not None
    assert accented.strokes[: len(plain.strokes)] == plain.strokes
    assert len(accented.strokes) == len(plain.strokes) + 2
    assert accented.advance == plain.advance


def test_an_i_loses_its_dot_under_an_accent() -> None:
    plain, accented = glyph_of("i"), glyph_of("í")
    assert plain is not None
    assert accented is not None
    assert len(plain.strokes) == len(accented.strokes) == 2


def test_how_a_text_is_spelled() -> None:
    assert spelled("P-12/3", {}).replaced == ()
    assert spelled("P\u201312", {}) == spelled("P-12", {})  # dashes are one
    assert spelled("A\u0308", {}).text == "Ä"
    omega = spelled("5 Ω", {})
    assert omega.text == "5 [GREEK CAPITAL LETTER OMEGA]"
    assert omega.replaced == (("Ω", "[GREEK CAPITAL LETTER OMEGA]"),)
    assert spelled("5 Ω", {"Ω": "OHM"}).text == "5 OHM"
    assert spelled("½", {}).text == "1/2"


@given(st.text(st.characters(exclude_categories=("Cs",)), max_size=20))
def test_no_character_is_lost(text: str) -> None:
    done = spelled(text, {})
    assert all(glyph_of(sign) is not None for sign in done.text)
    for sign, other in done.replaced:
        assert other.strip("[]")
        if other.startswith("["):
            assert other[1:-1] == name(sign, f"U+{ord(sign):04X}")
    assert len(done.text) >= len([s for s in text if s.isascii() and s.isprintable()])


def test_the_font_says_where_it_comes_from() -> None:
    assert "Dr. A. V. Hershey" in _font("hershey").source
    assert body_share() == 0.75
