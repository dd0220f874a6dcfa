"""What real files do that a strict parser chokes on: each is read, or refused by its code."""

import re

import pytest

from beamcam.geometry.curves import Arc, Line, signed_area
from beamcam.model.part import Bevel, Hole, Slot
from beamcam.readers.dstv import looks_like, read
from beamcam.readers.dstv.blocks import CODES
from tests.conftest import SAMPLES

HEADER = [
    *("ORDER-7", "D-1", "1", "P1", "S355J2", "2", "IPE300", "I"),
    *("1000.00", "300.00", "150.00", "10.70", "7.10", "15.00", "42.200", "1.160"),
    *("0.000", "0.000", "0.000", "0.000"),
]
NOTES = ["", "", "", ""]
PLATE = {7: "PL10*300", 8: "B"}
SQUARE = ["AK", "  v 0.00u 0.00 0.00", "  1000.00 0.00", "  1000.00 300.00", "  0.00 300.00"]


def text(*body, changes=None, notes=NOTES, end="\n", indent="  "):
    """A file of the given body; `changes` replaces header lines by their number."""
    header = list(HEADER)
    for number, value in (changes or {}).items():
        header[number - 1] = value
    lines = ["ST", *(indent + line for line in [*header, *notes]), *body, "EN"]
    return end.join(lines)


def reading_of(*body, **options):
    return read(text(*body, **options).encode("latin-1"), "part.nc1")


def part_of(*body, **options):
    reading = reading_of(*body, **options)
    assert not reading.refused, reading.diagnostics
    return reading.parts[0]


def codes_of(*body, **options):
    return [d.code.removeprefix("dstv-") for d in reading_of(*body, **options).diagnostics]


def only_feature(*body, **options):
    (feature,) = part_of(*body, **options).features
    return feature


# --- the file -----------------------------------------------------------------------------------


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_line_ends(end):
    assert part_of("BO", "  v 10.00s 20.00 18.00", end=end).mark == "P1"


def test_code_pages():
    for data in ("Труба".encode("cp1251"), b"\xef\xbf\xbd\xef\xbf\xbd", "Träger".encode("latin-1")):
        file = text().encode().replace(b"IPE300", data)
        (part,) = read(file, "p.nc1").parts
        assert part.length == 1000
    assert read(text().encode("utf-8-sig"), "p.nc1").parts[0].mark == "P1"
    assert read(text().encode("utf-16"), "p.nc1").parts[0].mark == "P1"


def test_blanks_behind_codes_and_between_blocks():
    assert (
        len(part_of("BO   ", "  v 1.0 2.0 18.0", "", "  ", "BO\t", "  v 3.0 2.0 18.0").features)
        == 2
    )


def test_tabs_separate():
    hole = only_feature("BO", "  v\t\t35.00o\t\t60.00\t\t22.00\t\t0.0\t\t0.0\t\t0.0")
    assert (hole.x, hole.y, hole.diameter, hole.edge) == (35, 60, 22, "o")


def test_comment_before_st_and_behind_en():
    part = read(b"** first\n" + text().encode() + b"\n** last\n", "p.nc1").parts[0]
    assert [(c.text, c.before) for c in part.comments] == [
        (" first", "start"),
        (" last", "after-end"),
    ]


def test_end_mark_of_dos():
    assert not read(text().encode() + b"\r\n\x1a", "p.nc1").refused


def test_messages_stay_readable():
    (said,) = reading_of("BO", "  v " + "1 " * 10_000).diagnostics
    assert len(str(said)) < 300


def test_looks_like():
    assert looks_like(text().encode())
    assert looks_like(text("BO").replace("ST", "T", 1).encode())
    assert not looks_like(b"G21\nG90\nM30\n")
    assert not looks_like(b"")


@pytest.mark.parametrize(
    ("file", "code"),
    [
        ("ST NA=1 NO=2 Q=3\nEN\nBO XD=10 YD=20\nEN\n", "dstv-no-st"),
        ("hello\n", "dstv-not-dstv"),
        ("", "dstv-not-dstv"),
        (text("BO", "  v 1.0 2.0 18.0", "EN", "SI", "  v 1.0 2.0 0.0 10 x"), "dstv-after-en"),
        (text("BO XD=10 YD=20"), "dstv-row-lost"),
        (text("BO", "  XD=10 YD=20"), "dstv-face"),
        (text("BO", "  v XD=10 YD=20"), "dstv-hole-fields"),
        (text("BO", "  W 10.0 20.0 18.0"), "dstv-face"),
        (text("M99"), "dstv-row-lost"),
        (text("BO", "  v 1.0 2.0 18.0", "M99"), "dstv-face"),
        (text(changes={3: "NA=5", 6: "Q=3"}), "dstv-quantity"),
        (text("BO", "  v nan 2.0 18.0"), "dstv-hole-fields"),
        (text("BO", "  v 1_0 2.0 18.0"), "dstv-hole-fields"),
        (text("AK", "  v inf 0.0"), "dstv-contour-fields"),
        (text("AK", "  v 1e400 0.0"), "dstv-contour-fields"),
        (text("BO", "  v 9" + "9" * 400 + " 2.0 18.0"), "dstv-hole-fields"),
        (text(changes={6: "9" * 5000}), "dstv-quantity"),
        (text(changes={10: "nan"}), "dstv-header-number"),
        (text(changes={9: ""}), "dstv-length"),
        (text(changes={9: "-5.00"}), "dstv-length"),
        (text(changes={9: "0.00"}), "dstv-length"),
    ],
)
def test_refused(file, code):
    reading = read(file.encode(), "x.nc1")
    assert code in [d.code for d in reading.diagnostics]
    assert reading.refused
    assert all(d.source.line for d in reading.diagnostics)


# --- the header ---------------------------------------------------------------------------------


@pytest.mark.parametrize("angle", [90.0, -90.0, -360.0, 1e9])
@pytest.mark.parametrize("line", [17, 18, 19, 20])
def test_a_cut_along_the_part_is_none(line, angle):
    said, *_ = read(text(changes={line: f"{angle:.3f}"}).encode(), "x.nc1").diagnostics
    assert said.code == "dstv-header-number"
    assert said.message.endswith("expected a number between -90 and 90")


def test_a_size_is_not_below_0():
    said, *_ = read(text(changes={10: "-5.00"}).encode(), "x.nc1").diagnostics
    assert said.message.endswith("expected a number of at least 0")


@pytest.mark.parametrize("count", [0, 1, 2, 3, 4])
def test_text_lines_may_be_fewer(count):
    notes = ["a", "b", "c", "d"][:count]
    part = part_of("BO", "  v 10.00s 20.00 18.00", notes=notes)
    assert part.notes == tuple(notes)
    assert len(part.features) == 1


def test_more_than_24_lines():
    part = part_of("BO", "  v 10.00s 20.00 18.00", notes=[*NOTES, "", "a fifth"])
    assert part.notes[-1] == "a fifth"
    assert len(part.features) == 1


def test_texts_that_are_or_begin_with_codes():
    changes = {1: "ST", 2: "EN", 4: "B1", 5: "ST37", 7: "STRIP10*110"}
    part = part_of("BO", "  v 1.0 2.0 18.0", changes=changes, notes=["BOLT", "SIDE", "EN", "E1"])
    assert (part.order, part.drawing, part.mark, part.grade) == ("ST", "EN", "B1", "ST37")
    assert part.profile.name == "STRIP10*110"
    assert part.notes == ("BOLT", "SIDE", "EN", "E1")


def test_lines_without_blanks_count_by_position():
    part = part_of("BO", "v 10.00s 20.00 18.00", changes={4: "P1"}, indent="")
    assert part.mark == "P1"
    assert len(part.features) == 1
    assert codes_of("BO", "v 10.00s 20.00 18.00", indent="") == ["indent"]


def test_dash_is_an_empty_value():
    part = part_of(changes={1: "-", 2: "-", 3: "-"}, notes=["-", "x", "-", "-"])
    assert (part.order, part.drawing, part.phase, part.notes) == ("", "", "", ("", "x"))


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("500.40,500.40", (500.4, 500.4)),
        ("500.40, 510", (500.4, 510)),
        ("500.40", (500.4, None)),
        ("500,510", (500, 510)),
    ],
)
def test_a_comma_means_the_saw_length(line, expected):
    part = part_of(changes={9: line})
    assert (part.length, part.saw_length) == expected


def test_decimal_commas_all_over_the_header():
    part = part_of(changes={9: "6000,50", 10: "300,00"})
    assert (part.length, part.saw_length, part.profile.height) == (6000.5, None, 300)
    assert codes_of(changes={9: "6000,50", 10: "300,00"}) == ["decimal-comma", "decimal-comma"]


@pytest.mark.parametrize("code", ["I", "U", "L", "M", "RO", "RU", "C", "T", "B", "SO"])
def test_profile_codes(code):
    assert part_of(changes={8: code}).profile.code == code


def test_mark_in_another_field():
    file = text(changes={2: "P7", 4: "991"}).encode()
    assert [d.code for d in read(file, "out/P7.nc1").diagnostics] == ["dstv-mark-elsewhere"]
    assert read(file, "other.nc1").diagnostics == ()


# --- holes --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("row", "kind", "depth", "angle"),
    [
        ("v 100.00u100.00 18.0 0.0", "through", None, None),
        ("v100.00u100.00 18.0", "through", None, None),
        ("v100.00u100.00 18.0 6.0", "blind", 6, None),
        ("v100.00u100.00 18.0 7.1", "through", None, None),  # as deep as the web is thick
        ("v 100.00u100.00g18.0 0.0", "thread", None, None),
        ("v 100.00u100.00 l18.0 9.0", "left-thread", 9, None),
        ("v 100.00u100.00s18.0 12.0", "countersink", 12, None),
        ("v 100.00u100.00s18.0 8.0 0.0 0.0 90.0", "countersink", 8, 90),
        ("v 100.00 u 100.00 s 18.0 8.0 0.0 0.0 90.0", "countersink", 8, 90),
        ("v 100.00u 100.00 18.00 0.0 0.0 0.0", "through", None, None),
        ("v 100.00u 100.00 18.00 0.00 0.00 0.00 0.00", "through", None, None),
    ],
)
def test_hole_rows(row, kind, depth, angle):
    hole = only_feature("BO", row)
    assert isinstance(hole, Hole)
    assert (hole.face, hole.x, hole.y, hole.diameter, hole.edge) == ("v", 100, 100, 18, "u")
    assert (hole.kind, hole.depth, hole.angle) == (kind, depth, angle)
    assert hole.source.line == 27


@pytest.mark.parametrize(
    ("code", "row", "kinds"),
    [
        ("I", "o 100.00s 40.00 18.00 {}", "bttt"), ("U", "u 100.00s 40.00 18.00 {}", "bttt"),
        ("M", "v 100.00u 40.00 18.00 {}", "bttb"), ("RU", "v 100.00u 0.00 18.00 {}", "bbbb"),
        ("B", "o 100.00u 3.00 8.00 {}", "bbbb"), ("I", "v 100.00u 90.00 18.00 {} l 20.00", "bttt"),
    ],
)  # fmt: skip
def test_a_depth_of_the_wall_is_through(code, row, kinds):
    """A wall of 10.7 mm all round: less is blind, and so is what may reach the next wall."""
    for depth, kind in zip((5.0, 10.7, 20.0, 140.0), kinds, strict=True):
        changes = {8: code, 13: "10.70"}
        (feature,) = part_of("BO", f"  {row.format(depth)}", changes=changes).features
        assert (feature.kind, feature.depth) == (
            ("through", None) if kind == "t" else ("blind", depth)
        )


def test_names_and_sizes():
    assert codes_of(changes={10: "270.00"}) == ["name-sizes"]
    tube = {7: "SHS100*5", 8: "M", 10: "100", 11: "100", 12: "5", 13: "5", 15: "0"}
    assert codes_of(changes=tube) == []
    turned = {7: "L150*100*10", 8: "L", 10: "100", 11: "150", 12: "10", 13: "10", 14: "12", 15: "0"}
    assert codes_of(changes=turned) == []
    assert "inches" in codes_of(changes={7: "W8X21", 10: "8.28", 15: "0"})
    assert codes_of(changes={7: "W200X31", 10: "210", 15: "0"}) == []
    assert codes_of(changes={7: "C41X41", 8: "U", 10: "41", 15: "0"}) == []


def test_marks():
    for row in ("v 10.0 10.0 m0.0 0.0", "v 10.0 10.0 0.00", "v 10.00m0.00"):
        reading = reading_of("BO", row)
        if row == "v 10.00m0.00":
            assert reading.refused
        else:
            assert reading.parts[0].features[0].kind == "mark"


@pytest.mark.parametrize(
    ("row", "centre", "size"),
    [
        ("v 115.58s 46.80 31.78 0.00l 0.00 6.40 0.00", (115.58, 50.0), (0, 6.4, 0)),
        ("v 115.58s 46.80 31.78l0.00 6.40 0.00", (115.58, 50.0), (0, 6.4, 0)),
        ("v 115.58s 46.80 31.78 0.00 l 0.00 6.40", (115.58, 50.0), (0, 6.4, 0)),
        ("v 100.00s 50.00 18.00 0.00l 22.00 0.00 0.00", (111.0, 50.0), (22, 0, 0)),
        ("v 100.00s 50.00 18.00 0.00l 22.00", (111.0, 50.0), (22, 0, 0)),
        ("v 100.00s 50.00 18.00 0.00l 22.00 0.00 90.00", (100.0, 61.0), (22, 0, 90)),
        ("v 100.00s 50.00 18.00 0.00l 40.00 20.00 0.00", (120.0, 60.0), (40, 20, 0)),
        ("v 100.00s 50.00 18.00 0.00l 40.00 20.00 90.00", (90.0, 70.0), (40, 20, 90)),
        ("v 100.00s 50.00 18.00 0.00 22.00 0.00 0.00", (111.0, 50.0), (22, 0, 0)),
    ],
)
def test_slot_rows(row, centre, size):
    slot = only_feature("BO", row)
    assert isinstance(slot, Slot)
    assert (slot.x, slot.y) == pytest.approx(centre)
    assert (slot.length, slot.height, slot.angle) == size


@pytest.mark.parametrize(("b", "h"), [(30.0, -10.0), (-30.0, 0.0), (-30.0, -10.0)])
def test_a_slot_to_the_other_side_of_its_first_circle(b, h):
    slot = only_feature("BO", f"  v 100.00s 50.00 20.00 0.00l {b:.2f} {h:.2f} 0.00")
    assert (slot.x, slot.y) == (100 + b / 2, 50 + h / 2)
    assert (slot.length, slot.height) == (abs(b), abs(h))


def test_face_and_reference_are_inherited_in_a_block():
    part = part_of("BO", "  o 10.00s 20.00 18.00", "  30.00 20.00 18.00", "BO", "  u 1.0 2.0 18.0")
    assert [(f.face, f.edge) for f in part.features] == [("o", "s"), ("o", "s"), ("u", "")]


def test_tubes_keep_both_walls():
    part = part_of("BO", "  h 10.0 20.0 18.0", "BO", "  v 10.0 20.0 18.0", changes={8: "M"})
    assert [f.face for f in part.features] == ["h", "v"]


# --- texts --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("tail", "height", "option", "found"),
    [
        ("10r1009", 10, "r", "1009"),
        ("20r516", 20, "r", "516"),
        ("025  pc25", 25, "", "pc25"),
        ("012   0008-SE0008", 12, "", "0008-SE0008"),
        ("76         B_1", 76, "", "B_1"),
        ("10r1", 10, "r", "1"),
        ("12P1719", 12, "", "P1719"),
        ("5 1/1/1", 5, "", "1/1/1"),
        ("10z two words", 10, "z", "two words"),
        ("10 r7", 10, "", "r7"),
        ("10 7", 10, "", "7"),
        ("10 A**B", 10, "", "A**B"),
    ],
)
def test_text_rows(tail, height, option, found):
    mark = only_feature("SI", f"  v   30.00u  134.44    0.00 {tail}")
    assert (mark.x, mark.y, mark.angle, mark.edge) == (30, 134.44, 0, "u")
    assert (mark.height, mark.option, mark.text) == (height, option, found)


@pytest.mark.parametrize(
    "row", ["v 30.00u 20.00 0.00", "v 30.00u 20.00 0.00 10", "v 1.0 2.0 0.0 10r"]
)
def test_texts_without_text_mark_nothing(row):
    assert codes_of("SI", "  " + row) == ["no-marking"]


def test_a_missing_number_is_not_made_of_another():
    assert "text-fields" in codes_of("SI", "  v 30.00 134.44 10 P1")


# --- contours -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "tail", ["", " 0.00", " 0.00 0.00 0.00", " 0.00 0.00 0.00 0.00 0.00", " 0.00 0.00"]
)
def test_contour_rows_of_any_length(tail):
    contour = only_feature(
        *(
            row if row == "AK" else row.split(" 0.00 0.00")[0] + tail
            for row in [
                "AK",
                "  v 0.00u 0.50",
                "  1000.00 0.50",
                "  1000.00 300.00",
                "  0.00 300.00",
                "  0.00 0.50",
            ]
        )
    )
    assert len(contour.curves) == 4
    assert contour.kind == "outer"
    assert contour.closed


def test_clockwise_contour_is_turned_and_its_arcs_keep_their_meaning():
    corner = ["  v 0.0 0.0", "  0.0 290.0 -10.0", "  10.0 300.0", "  1000.0 300.0", "  1000.0 0.0"]
    contour = only_feature("AK", *corner, "  0.0 0.0")
    arc = next(c for c in contour.curves if isinstance(c, Arc))
    assert signed_area(contour.curves) > 0
    assert arc.sweep_deg == pytest.approx(90)
    assert arc.centre == pytest.approx((10, 290))


def arcs_on(face, code, rows):
    (contour,) = (c for c in part_of(*rows).contours if c.face == face and c.kind == code)
    return [c for c in contour.curves if isinstance(c, Arc)], contour


def test_arcs_on_a_mirrored_face_turn_their_sign():
    """Clockwise in the numbers of h is the standard's way: a round corner has a positive radius."""
    rows = ["AK", "  h 0.0 0.0", "  0.0 290.0 10.0", "  10.0 300.0", "  1000.0 300.0"]
    (arc,), contour = arcs_on("h", "outer", [*rows, "  1000.0 0.0", "  0.0 0.0"])
    assert arc.centre == pytest.approx((10, 290))
    assert signed_area(contour.curves) < 0


def test_arcs_on_an_unmirrored_face_keep_their_sign():
    rows = [
        "AK",
        "  o 0.0 0.0",
        "  1000.0 0.0",
        "  1000.0 140.0 10.0",
        "  990.0 150.0",
        "  0.0 150.0",
    ]
    (arc,), contour = arcs_on("o", "outer", [*rows, "  0.0 0.0"])
    assert arc.centre == pytest.approx((990, 140))
    assert signed_area(contour.curves) < 0


def test_inner_contours_follow_the_outer_one_of_their_face():
    outer = ["AK", "  h 0.0 0.0", "  0.0 300.0", "  1000.0 300.0", "  1000.0 0.0", "  0.0 0.0"]
    inner = ["IK", "  h 100.0 100.0", "  140.0 100.0 -10.0", "  150.0 110.0", "  150.0 150.0"]
    (arc,), contour = arcs_on("h", "inner", [*outer, *inner, "  100.0 100.0"])
    assert arc.centre == pytest.approx((140, 110))
    assert signed_area(contour.curves) > 0


def test_full_circle_of_two_half_circles():
    circle = ["AK", "  v 0.00u 0.00 116.85", "  0.00 233.70 116.85", "  0.00 0.00"]
    part = part_of(
        *circle, "BO", "  v -56.94s 76.13 25.0", changes={**PLATE, 9: "233.7", 10: "233.7"}
    )
    contour, _ = part.features
    assert abs(signed_area(contour.curves)) == pytest.approx(42895, abs=1)
    assert codes_of(*circle, changes={**PLATE, 9: "233.7", 10: "233.7"}) == []


def test_notch_rows_are_no_points():
    contour = only_feature(
        "AK",
        "  v 0.0 0.0",
        "  990.0 0.0 10.0",
        "  1000.0 0.0t 10.0",
        "  1000.0 10.0",
        "  1000.0 300.0",
        "  1000.00 300.00w 0.00",
        "  0.0 300.0",
        "  0.0 0.0",
    )
    assert [(n.curve, n.kind, n.corner, n.radius) for n in contour.notches] == [
        (1, "t", (1000, 0), 10),
        (3, "w", (1000, 300), 0),
    ]
    assert [type(c) for c in contour.curves] == [Line, Arc, Line, Line, Line]


@pytest.mark.parametrize("corner", ["-16611181.71 -90.16t", "367250604.00 71.29t"])
def test_notch_corners_far_away_are_left_out(corner):
    body = [*SQUARE[:3], f"  {corner} 9.00", *SQUARE[3:], "  0.00 0.00"]
    assert only_feature(*body).notches == ()
    assert codes_of(*body) == ["notch-corner"]


def test_bevels():
    rows = ["AK", "  v 0.0 0.0 0.0 -45.0 7.0 45.0 9.0", "  1000.0 0.0 0.0 30.0 0.0", *SQUARE[3:]]
    contour = only_feature(*rows, "  0.0 0.0")
    assert contour.bevels == (Bevel(0, -45, 7), Bevel(0, 45, 9), Bevel(1, 30, 0))


def test_bevels_follow_their_edge_when_a_contour_is_turned():
    rows = ["AK", "  v 0.0 0.0", "  0.0 300.0 0.0 30.0 0.0", "  1000.0 300.0", "  1000.0 0.0"]
    contour = only_feature(*rows, "  0.0 0.0")
    (bevel,) = contour.bevels
    curve = contour.curves[bevel.curve]
    assert {curve.start, curve.end} == {(0, 300), (1000, 300)}


def test_a_closing_row_may_repeat_the_first_bevel():
    rows = [row + " 0.00 -30.00 7.10" for row in SQUARE[2:]]
    contour = only_feature(
        "AK", "  v 0.00u 0.00 0.00 -30.00 7.10", *rows, "  0.0 0.0 0.0 -30.00 7.10"
    )
    assert [b.curve for b in contour.bevels] == [0, 1, 2, 3]


def test_several_contours_in_one_block():
    a = ["  v 10.0 10.0", "  20.0 10.0", "  20.0 20.0", "  10.0 10.0"]
    b = ["  v 40.0 10.0", "  50.0 10.0", "  50.0 20.0", "  40.0 10.0"]
    assert len(part_of("IK", *a, *b).features) == 2
    assert len(part_of("IK", *a, *b, *a).features) == 3
    touching = [
        "  v 10.0 10.0",
        "  20.0 10.0",
        "  20.0 20.0",
        "  10.0 10.0",
        "  0.0 10.0",
        "  0.0 5.0",
    ]
    assert len(part_of("IK", *touching, "  10.0 10.0").features) == 1


def test_a_face_letter_that_changes_begins_a_contour():
    part = part_of("KO", "  v 1.0 2.0", "  v 3.0 2.0", "  u 5.0 2.0", "  u 6.0 2.0")
    assert [c.face for c in part.contours] == ["v", "u"]


def test_scribe_lines_and_powder():
    part = part_of(
        "KO", "  v 1.0 2.0", "  3.0 2.0", "PU", "  v 1.0 2.0", "  3.0 2.0", "  3.0 4.0", "  1.0 2.0"
    )
    assert [(c.kind, c.process, c.closed) for c in part.contours] == [
        ("open", "punch", False),
        ("inner", "powder", True),
    ]


# --- other blocks -------------------------------------------------------------------------------


def test_planes_of_one_number_used_again():
    plane = ["  0.0 0.0 90.0 100.0 0.0 90.0", "  0.0 151.0 41.0"]
    part = part_of(
        "E1",
        *plane,
        "B1",
        "  1100.00u 53.0 18.0",
        "S1",
        "  100.00u 50.00 0000.00",
        "E1",
        *plane,
        "B1",
        "  5.0u 53.0 18.0",
        "A1",
        "  0.0 0.0",
        "  9.0 0.0",
        "  9.0 9.0",
        "  0.0 0.0",
    )
    assert [p.name for p in part.planes] == ["E1", "E1#2"]
    assert part.planes[0].along_y == (0, 151, 41)
    assert [f.face for f in part.features] == ["E1", "E1#2", "E1#2"]


def test_bends_section_information_and_the_rest():
    part = part_of(
        *("KA", "  25.0 0.0 25.0 100.0 -90.0 15.0", "  225.0 0.0 225.0 100.0 90.0"),
        *("PR", "  + 0.0 79.5 0.0", "  -9.0 1.0 2.0"),
        *("TO", "  -1.0 1.0", "UE", "  v 500.0 12.0"),
        *("SC", "  0.0 0.0 0.0", "  -1.0 0.0 0.5"),
        *("IN", "  COATING : hot dip : 85", "  no colon here"),
        changes={8: "SO"},
    )
    assert [(b.angle, b.radius) for b in part.features[:2]] == [(-90, 15), (90, None)]
    assert [(p.side, p.y) for p in part.section] == [("+", 0), ("-", 9)]
    assert part.tolerance == (-1, 1)
    assert (part.features[2].x, part.features[2].y) == (500, 12)
    assert part.features[3].normal == (-1, 0, 0.5)
    assert part.info == (("COATING", "hot dip : 85"), ("", "no colon here"))


def test_empty_information_block():
    assert codes_of("IN") == []


SQUARE_END = ["0.0 0.0", "1000.0 0.0", "1000.0 300.0", "0.0 300.0"]
SHORT_BELOW = ["0.0 0.0", "973.75 0.0", "1000.0 300.0", "0.0 300.0"]
MITRE = ["0.0 150.0", "150.0 0.0", "1000.0 0.0", "1000.0 150.0"]
COPED = ["0.0 40.0", "60.0 0.0", "1000.0 0.0", "1000.0 300.0", "0.0 300.0"]


@pytest.mark.parametrize(
    ("face", "cuts", "corners", "codes"),
    [
        ("v", {17: "5.000"}, ["0.0 300.0", "26.25 0.0", "1000.0 0.0", "1000.0 300.0"], []),
        ("v", {18: "-5.000"}, SHORT_BELOW, []),
        ("v", {18: "0.070"}, SQUARE_END, []),
        ("v", {18: "5.000"}, SHORT_BELOW, ["cut-angle"]),
        ("v", {18: "5.000"}, SQUARE_END, ["cut-angle"]),
        ("v", {}, SHORT_BELOW, ["cut-missing"]),
        ("u", {19: "45.00"}, MITRE, []),
        ("u", {19: "-45.0"}, MITRE, ["cut-angle"]),
        ("v", {17: "5.000"}, COPED, []),  # a coped end says nothing about the cut
    ],
)
def test_cut_angles_against_the_contour(face, cuts, corners, codes):
    rows = [f"  {face} {corner} 0.00" for corner in [*corners, corners[0]]]
    assert codes_of("AK", *rows, changes=cuts) == codes


def test_holes_in_a_notch_are_in_the_air():
    rows = [
        "  v 0.0 0.0",
        "  1000.0 0.0",
        "  1000.0 250.0",
        "  900.0 250.0",
        "  900.0 300.0",
        "  0.0 300.0",
    ]
    body = ["AK", *rows, "  0.0 0.0", "BO"]
    assert codes_of(*body, "  v 950.0 275.0 18.0") == ["hole-outside"]
    assert codes_of(*body, "  v 950.0 225.0 18.0") == []
    arc = [
        "AK",
        "  v 0.0 0.0",
        "  1000.0 0.0 150.0",
        "  1000.0 300.0",
        "  0.0 300.0",
        "  0.0 0.0",
        "BO",
    ]
    assert codes_of(*arc, "  v 1100.0 150.0 18.0", changes={9: "1150.00"}) == []
    assert codes_of(*arc, "  v 1140.0 280.0 18.0", changes={9: "1150.00"}) == ["hole-outside"]


def test_unrolled_round_section():
    assert codes_of("BO", "  v 100.0 350.0 18.0", changes={8: "RO", 10: "114.3"}) == []
    assert codes_of("BO", "  v 100.0 370.0 18.0", changes={8: "RO", 10: "114.3"}) == [
        "hole-outside"
    ]


def test_comments_keep_their_places():
    part = part_of(
        "** before the block",
        "BO",
        "** before the row",
        "  v 1.0 2.0 18.0",
        "** between",
        "  v 3.0 2.0 18.0",
        "** before the contour",
        *SQUARE[:2],
        "** in it",
        *SQUARE[2:],
        "  0.00 0.00",
        "** before the end",
    )
    assert [(c.text, c.before) for c in part.comments] == [
        (" before the block", "block:feature:0"),
        (" before the row", "feature:0"),
        (" between", "feature:1"),
        (" before the contour", "block:feature:2"),
        (" in it", "feature:2:1"),
        (" before the end", "end"),
    ]


def test_comment_behind_data():
    part = part_of("BO", "  v 1.0 2.0 18.0 ** FERTIGUNGSART=1")
    assert [(c.text, c.before) for c in part.comments] == [("FERTIGUNGSART=1", "feature:0")]


# --- capitals -------------------------------------------------------------------------------------

FACE_AND_X = re.compile(r"^(\s+)([vouh](?=\s*[-+.0-9]))?(\s*[-+0-9.]+)([uos](?=\s))?", re.MULTILINE)


@pytest.mark.parametrize("sample", sorted((SAMPLES / "dstv").glob("*.nc1")), ids=lambda p: p.stem)
def test_faces_and_references_in_capitals_are_the_same_part(sample):
    """Whatever the blocks, and told once for each that has one."""
    text = sample.read_text()
    start = next(m.start() for m in re.finditer(r"(?m)^[A-Z][A-Z0-9]$", text) if m.start() > 100)
    head, blocks = text[:start], text[start:]

    def shout(match):
        return "".join(one or "" for one in match.groups()).upper()

    loud = head + FACE_AND_X.sub(shout, blocks)
    read_so, said = (read(t.encode(), sample.name) for t in (text, loud))
    assert loud != text
    assert said.parts == read_so.parts
    assert {d.code for d in said.diagnostics} - {d.code for d in read_so.diagnostics} == {
        "dstv-face-case"
    }
    count = sum(d.code == "dstv-face-case" for d in said.diagnostics)
    assert 0 < count <= sum(line in CODES for line in loud.splitlines())


def test_only_faces_and_references_may_be_capitals():
    assert codes_of("BO", "  V 10.00S 20.00 18.00", "  H 20.00 20.00 18.00") == ["face-case"]
    assert codes_of("BO", "  W 10.00 20.00 18.00") == ["face"]
    assert "face" in codes_of("BO", "  S 10.00 20.00 18.00")
    assert "hole-fields" in codes_of("BO", "  v 10.00 20.00 G18.00")
