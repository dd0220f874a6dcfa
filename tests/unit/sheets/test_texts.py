"""Texts on sheets: where they stand, and what the read-back says of those that stand elsewhere."""

import re
from collections import Counter
from collections.abc import Callable, Iterable

import pytest
import shapely
import shapely.affinity
from hypothesis import Phase, given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam import pipeline
from beamcam.controllers import table_events
from beamcam.controllers.events import Move, Switch
from beamcam.errors import Diagnostic, Source, errors_in
from beamcam.geometry.curves import Arc, Curve, Line
from beamcam.machine import load
from beamcam.machine.machine import Machine
from beamcam.model.part import Contour, Feature, Hole, Part, TextMark
from beamcam.model.request import Request
from beamcam.pipeline import Posted, RefusedProgram, post, read_back
from beamcam.planning.left_out import REASONS
from beamcam.planning.left_out import TEXT_MOVED as PLAN_MOVED
from beamcam.planning.lettering import Lettered, place_text
from beamcam.planning.lettering_room import Room
from tests.conftest import examples
from tests.letters import Lines, read
from tests.unit.sheets.parts import S, box, circle, contour, drawing, plate

PLATE = load("plate-linuxcnc")
HOLE = Hole("v", 60.0, 50.0, 30.0, S)


def text(
    words: str, x: float = 20.0, y: float = 40.0, angle: float = 0.0, height: float = 10.0,
    face: str = "v", **more: str,
) -> TextMark:  # fmt: skip
    return TextMark(face, x, y, angle, height, words, S, **more)  # type: ignore[arg-type]


def lettered(program: str, machine: Machine = PLATE) -> Lines:
    """The lines that a program draws with the marking tool, in its coordinates."""
    events, said = table_events(program, machine)
    assert not said
    found: Lines = []
    marks = False
    for event in events:
        if isinstance(event, Switch):
            marks = event.number == 3 and "$" in event.words
        elif isinstance(event, Move) and marks and not event.rapid:
            found.append((event.start, event.end))
    return found


def found_in(program: str, *parts: Part, machine: Machine = PLATE) -> list[Diagnostic]:
    return [*read_back(program, Request(parts, machine))]


def codes(said: Iterable[Diagnostic]) -> list[str]:
    return [one.code for one in said]


def moved(posted: Posted) -> list[str]:
    return [said.message for said in posted.remarks if said.code == "plan-text-moved"]


@pytest.mark.parametrize("angle", [0.0, 30.0, 90.0, 180.0, -45.0])
def test_a_text_that_stands_free_stands_where_the_part_has_it(angle: float) -> None:
    words = "P-12/b7"
    part = plate(text(words, 100.0, 50.0, angle, 6.0))
    posted = post([part], PLATE)
    assert posted.remarks == ()
    lines = lettered(posted.text)
    assert read(lines, 6.0, angle) == words
    xs = [x for line in lines for x, _ in line]
    if angle == 0.0:  # the margin of the sheet, and the P's own distance from its beginning
        assert min(xs) == pytest.approx(10 + 100 + 6 * 4 / 21, abs=1e-3)


@given(
    # Of dashes alone nobody can say how high above their baseline they stand.
    st.text("ABCDEFGHJKLMNOPRSTUVWXYZ0123456789-", min_size=1, max_size=8).filter(
        lambda words: words.strip("-")
    ),
    st.floats(-20, 220), st.floats(-20, 120), st.sampled_from([0.0, 90.0, 180.0, 17.0]),
    st.floats(4.0, 30.0), st.lists(st.tuples(st.floats(20, 180), st.floats(20, 80)), max_size=3),
)  # fmt: skip
@settings(max_examples=examples(8), phases=[Phase.explicit, Phase.generate])
def test_a_text_is_read_and_clear_wherever_it_is_wanted(
    words: str, x: float, y: float, angle: float, height: float, holes: list[tuple[float, float]]
) -> None:
    steel = shapely.box(0, 0, 200, 100)
    features: list[Feature] = [text(words, x, y, angle, height)]
    for a, b in holes:
        disc = shapely.Point(a, b).buffer(8)
        if steel.buffer(-6).contains(disc):  # no narrower bridges than the torch leaves
            steel = steel.difference(disc)
            features.append(Hole("v", a, b, 16.0, S))
    if len(steel.interiors) < len(features) - 1:
        return  # holes that meet are another matter
    posted = post([plate(*features)], PLATE)
    (outcome,) = (o for o in posted.plan.outcomes if o.feature == (0, 0))
    lines = lettered(posted.text)
    if outcome.how == "listed":
        assert outcome.by == "no-room"
        assert not lines
        return
    high = moved(posted)
    size = float(re.findall(r"(\S+) mm high", high[0])[0]) if high else height
    assert read(lines, size, angle) == words
    drawn = shapely.MultiLineString(lines)
    on_part = shapely.affinity.translate(drawn, -10, -10)
    assert steel.buffer(-2.9).contains(on_part)


def test_a_text_over_a_hole_is_moved_by_the_least_way() -> None:
    posted = post([plate(HOLE, text("AB", 50.0, 45.0))], PLATE)
    assert [o.how for o in posted.plan.outcomes] == ["made", "made"]
    (said,) = moved(posted)
    assert "at x 50, y 45, 10 mm high" in said
    y = float(re.findall(r"y (\S+),", said)[0])
    assert y == pytest.approx(50 + 15 + 3, abs=0.6) or y == pytest.approx(50 - 15 - 3 - 10, abs=0.6)


def test_a_text_without_room_is_made_smaller() -> None:
    posted = post([plate(text("A LONG TEXT-1234567890", 10.0, 50.0, 0.0, 30.0))], PLATE)
    (said,) = moved(posted)
    size = float(re.findall(r"(\S+) mm high", said)[0])
    assert 5.0 < size < 12.0
    assert read(lettered(posted.text), size) == "ALONGTEXT-1234567890"


LISTED = {
    "no-room": text("X" * 80),
    "too-small": text("A", height=2.0),
    "blank": text("  "),
    "face": text("A", face="h"),
}


@pytest.mark.parametrize("why", LISTED)
def test_a_text_that_cannot_be_lettered_is_left_to_the_hand(why: str) -> None:
    part = plate(LISTED[why])
    posted = post([part], PLATE)
    assert [(o.how, o.by) for o in posted.plan.outcomes] == [("listed", why)]
    assert REASONS[why] in posted.remarks[0].message
    assert codes(found_in(posted.text, part)) == ["verify-by-hand"]


def test_binding_values_are_kept_or_nothing_is_made() -> None:
    free, over = text("A", option="z"), text("A", 55.0, 45.0, option="z")
    assert [o.how for o in post([plate(HOLE, free)], PLATE).plan.outcomes] == ["made", "made"]
    posted = post([plate(HOLE, over)], PLATE)
    assert [o.how for o in posted.plan.outcomes] == ["made", "listed"]


def test_two_texts_do_not_stand_on_one_another() -> None:
    part = plate(text("AAA"), text("BBB"))
    posted = post([part], PLATE)
    assert len(moved(posted)) == 1
    lines = lettered(posted.text)
    letters = shapely.union_all([shapely.LineString(line).buffer(0.1) for line in lines])
    assert len(shapely.get_parts(letters)) == 6  # no letter meets another


def test_a_text_is_not_written_inside_another() -> None:
    """The box of the one holds that of the other, and their sides are far from each other."""
    big, small = text("H", 20.0, 20.0, 0.0, 60.0), text("A", 30.0, 45.0, 0.0, 5.0)
    for asked in ((big, small), (small, big)):
        posted = post([plate(*asked)], PLATE)
        assert [o.how for o in posted.plan.outcomes] == ["made", "made"]
        assert len(moved(posted)) == 1


def rounded(x: float, y: float, width: float, height: float, radius: float) -> Contour:
    """A rectangle with round corners, outer or inner by its size."""
    a, b, r = x + width, y + height, radius
    curves: tuple[Curve, ...] = (
        Line((x + r, y), (a - r, y)), Arc((a - r, y + r), r, -90.0, 90.0),
        Line((a, y + r), (a, b - r)), Arc((a - r, b - r), r, 0.0, 90.0),
        Line((a - r, b), (x + r, b)), Arc((x + r, b - r), r, 90.0, 90.0),
        Line((x, b - r), (x, y + r)), Arc((x + r, y + r), r, 180.0, 90.0),
    )  # fmt: skip
    return Contour("v", "outer" if width > 190.0 else "inner", curves, S)


@given(
    st.lists(
        st.tuples(
            st.floats(-10, 210), st.floats(-10, 110), st.sampled_from([0.0, 90.0, 17.0, -120.0]),
            st.floats(3.0, 90.0), st.sampled_from(["A", "-", "P-12"]),
        ), min_size=1, max_size=5,
    ),
    st.floats(2.0, 45.0), st.sampled_from([0.0, 1.0, 3.0]), st.floats(3.0, 12.0),
)  # fmt: skip
@settings(max_examples=examples(6), phases=[Phase.explicit, Phase.generate])
def test_texts_between_rounded_edges_and_each_other_are_read_back(
    texts: list[tuple[float, float, float, float, str]], corner: float, apart: float, hole: float
) -> None:
    machine = replace(PLATE, marks=replace(PLATE.marks, min_distance=apart))
    outline = rounded(0.0, 0.0, 200.0, 100.0, corner)
    inner = rounded(120.0, 40.0, 3 * hole, 3 * hole, hole)
    asked = [text(words, *place, high) for *place, high, words in texts]
    posted = post([plate(outline, inner, *asked)], machine)
    assert {o.how for o in posted.plan.outcomes} <= {"made", "listed"}


def test_many_texts_without_room_are_listed_at_once() -> None:
    """What has no place for one has none for the next; no search is made twice."""
    machine = replace(PLATE, marks=replace(PLATE.marks, min_height=12.0))
    words = [text("W" * 6, 20.0, 40.0, 0.0, 14.0) for _ in range(30)]
    posted = post([plate(*words)], machine)
    counts = Counter(o.how for o in posted.plan.outcomes)
    assert counts["listed"] > 10
    assert counts["made"] >= 3


@pytest.mark.parametrize("y", [40.25, 40.05, -0.0, -1e-9])
def test_the_place_of_a_moved_text_may_be_rounded_either_way(y: float) -> None:
    """It is moved along x alone, so that its y is that of the part, which messages round."""
    crowded = plate(Hole("v", 60.0, 20.0, 20.0, S), text("AB", 50.0, y + 0.0, 0.0, 10.0))
    machine = replace(PLATE, marks=replace(PLATE.marks, min_distance=0.0))
    assert post([crowded], machine).plan.outcomes


def test_a_text_may_read_like_a_message() -> None:
    words = "at x 1.2.3, y 2, 3 mm high"
    part = plate(HOLE, text(words, 20.0, 45.0, 0.0, 4.0))
    assert len(moved(post([part], PLATE))) == 1


def test_texts_of_one_spelling_are_told_apart() -> None:
    part = plate(text("A1", 20.0, 20.0), text("A1", 120.0, 60.0))
    assert post([part], PLATE).remarks == ()


def test_texts_that_are_alike_may_stand_in_for_each_other() -> None:
    """Three at one place: which of them is moved where says nothing of the letters."""
    part = plate(*(replace(text("A7", 60.0, 40.0), source=Source("p.nc1", k)) for k in (1, 2, 3)))
    posted = post([part], PLATE)
    assert len(moved(posted)) == 2
    assert [read([*lines], 10.0) for lines in _words(posted.text)] == ["A7"] * 3


def _words(program: str) -> list[Lines]:
    """The lines of a program's letters by the height at which they stand."""
    found: dict[float, Lines] = {}
    for line in lettered(program):
        foot = next((y for y in found if abs(y - line[0][1]) < 11.0), line[0][1])
        found.setdefault(foot, []).append(line)
    return list(found.values())


def test_the_height_may_be_that_of_the_body() -> None:
    machine = replace(PLATE, marks=replace(PLATE.marks, height_of="body"))
    posted = post([plate(text("A7", height=20.0))], machine)
    assert read(lettered(posted.text), 15.0) == "A7"


def test_a_character_that_the_font_has_not_is_told_and_written_by_name() -> None:
    part = plate(text("5 Ω", 5.0, 40.0))
    posted = post([part], PLATE)
    assert "plan-text-sign" in codes(posted.remarks)
    assert "[GREEK CAPITAL LETTER OMEGA]" in posted.remarks[0].message
    machine = replace(PLATE, marks=replace(PLATE.marks, replace={"Ω": "OHM"}))
    posted = post([part], machine)
    assert read(lettered(posted.text), 10.0) == "5OHM"


def test_the_other_tables_letter_too() -> None:
    part = plate(text("L-7"))
    assert "M13" in post([part], load("plate-codesys")).text
    laser = replace(part, profile=replace(part.profile, web_thickness=3.0))
    done = post([laser], load("laser-grbl"))
    assert {op.row.process for op in done.plan.operations} == {"cut", "engrave"}  # type: ignore[union-attr]
    sheet = replace(part, profile=replace(part.profile, web_thickness=3.0), grade="")
    assert post([sheet], load("table-simotion")).plan.outcomes[0].how == "made"
    steps = post([laser], load("laser-stepper"), style=".csv")
    assert steps.plan.outcomes[0].how == "made"


def test_letters_that_a_table_of_steps_engraves_too_slowly_are_refused() -> None:
    laser = plate(text("L-7"))
    laser = replace(laser, profile=replace(laser.profile, web_thickness=3.0))
    machine = load("laser-stepper")
    rows = post([laser], machine, style=".steps").text.splitlines()
    head = next(k for k, row in enumerate(rows) if row.startswith("time_us")) + 1
    slow = [re.sub(r"^\d+", lambda t: f"{9 * int(t[0]):012d}", row) for row in rows[head:]]
    program = "\n".join([*rows[:head], *slow]) + "\n"
    said = [*read_back(program, Request((laser,), machine, style=".steps"))]
    assert "steps-speed" in codes(said)
    assert any("engrave" in one.message for one in said)


def test_a_drawing_that_is_only_lettered_stands_where_it_is_drawn() -> None:
    posted = post([drawing(text("AB"))], PLATE)
    assert read(lettered(posted.text), 10.0) == "AB"
    assert not errors_in(found_in(posted.text, drawing(text("AB"))))


def test_a_drawing_that_is_only_lettered_has_all_of_its_texts() -> None:
    both = drawing(text("AB"), text("CD", y=80.0))
    assert not errors_in(found_in(post([both], PLATE).text, both))
    assert "verify-sheet-missing" in codes(found_in(post([drawing(text("AB"))], PLATE).text, both))


# Programs and plans that letter otherwise than the part has it.


def other_part(change: Callable[[TextMark], TextMark]) -> tuple[str, Part]:
    """The program of a part whose text is another, and the part as it is."""
    asked = text("P12/b", 20.0, 10.0, 0.0, 10.0)
    hole = Hole("v", 140.0, 50.0, 20.0, S)
    return post([plate(hole, change(asked))], PLATE).text, plate(hole, asked)


WRONG: dict[str, Callable[[TextMark], TextMark]] = {
    "a character is another": lambda t: replace(t, text="P13/b"),
    "a letter is a capital": lambda t: replace(t, text="P12/B"),
    "a character is missing": lambda t: replace(t, text="P12/"),
    "a character is too much": lambda t: replace(t, text="P12/bb"),
    "two characters are swapped": lambda t: replace(t, text="P21/b"),
    "upside down": lambda t: replace(t, x=80.0, y=20.0, angle=180.0),
    "on its side": lambda t: replace(t, angle=90.0),
    "turned a little": lambda t: replace(t, angle=3.0),
    "moved though there is room": lambda t: replace(t, x=22.0),
    "smaller though there is room": lambda t: replace(t, height=9.0),
    "larger": lambda t: replace(t, height=11.0),
}


@pytest.mark.parametrize("how", WRONG)
def test_a_text_that_is_another_is_refused(how: str) -> None:
    program, part = other_part(WRONG[how])
    assert errors_in(found_in(program, part))


def test_a_text_that_is_mirrored_is_refused() -> None:
    part = plate(text("P12/b"))
    program = re.sub(
        r"(?<=\$1 S1\n)(.*?)(?=M5 \$1)",
        lambda m: re.sub(r"X(\S+)", lambda x: f"X{100 - float(x[1]):.4f}", m[1]),
        post([part], PLATE).text, flags=re.S,
    )  # fmt: skip
    program = re.sub(
        r"G0 X(\S+) (Y\S+)(?=\nM3 \$1)",
        lambda m: f"G0 X{100 - float(m[1]):.4f} {m[2]}", program,
    )  # fmt: skip
    assert read(lettered(program), 10.0) != "P12/b"
    assert errors_in(found_in(program, part))


def test_a_text_over_a_hole_or_an_edge_is_refused() -> None:
    asked = text("P12/b", 20.0, 10.0)
    hole = Hole("v", 40.0, 15.0, 12.0, S)
    free = post([plate(Hole("v", 140.0, 70.0, 12.0, S), asked)], PLATE).text
    over = post([plate(hole)], PLATE).text
    begin = free.index("G0")
    lettering = free[begin : free.index("M3 S")].rpartition("\nG0")[0] + "\n"
    program = over.replace("G0", lettering + "G0", 1)
    assert read(lettered(program), 10.0) == "P12/b"
    said = errors_in(found_in(program, plate(hole, asked)))
    assert "verify-text" in codes(said)
    assert "3 mm clear" in said[0].message
    # With the hole elsewhere the same lettering is right.
    assert not errors_in(found_in(free, plate(Hole("v", 140.0, 70.0, 12.0, S), asked)))


def test_a_text_that_is_not_made_though_it_could_be_is_refused() -> None:
    part = plate(text("P12"))
    program = post([replace(part, features=())], PLATE).text
    assert errors_in(found_in(program, part))
    crowded = plate(HOLE, text("P12", 50.0, 45.0))
    program = post([replace(crowded, features=(HOLE,))], PLATE).text
    assert errors_in(found_in(program, crowded))


@pytest.mark.parametrize("tell", [False, True])
def test_a_plan_that_tells_another_place_is_refused(
    tell: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    part = plate(HOLE, text("AB", 50.0, 45.0))
    row = pipeline.post_of(PLATE)

    def plan(job: object) -> object:
        made = row.plan(job)  # type: ignore[arg-type]
        kept = [said for said in made.remarks if said.code != "plan-text-moved"]
        (said,) = (said for said in made.remarks if said.code == "plan-text-moved")
        elsewhere = PLAN_MOVED.at(said.source, **{**dict(said.values), "x": "12.0"})
        told = [elsewhere] if tell else []
        return replace(made, remarks=(*kept, *told))

    monkeypatch.setattr(pipeline, "post_of", lambda machine: replace(row, plan=plan))
    with pytest.raises(RefusedProgram, match=" verify-text-told: found a text lettered"):
        post([part], PLATE)


def test_the_search_finds_the_nearest_room() -> None:
    """Against all places of a fine grid, tried one by one."""
    room = Room((0.0, 0.0, 60.0, 40.0))
    room.add(box(0, 0, 60, 40))
    room.add(circle(20, 15, 10))
    wanted = text("H", 18.0, 12.0, 0.0, 8.0)
    marks = PLATE.marks
    placed = place_text(wanted, marks, room)
    assert isinstance(placed, Lettered)
    ink = shapely.MultiLineString([list(s) for s in placed.strokes])
    steel = shapely.box(0, 0, 60, 40).difference(shapely.Point(20, 15).buffer(5, 64)).buffer(-3)
    assert steel.buffer(0.1).contains(ink.envelope)
    reach = min(
        (dx * dx + dy * dy) ** 0.5
        for dx in (k / 2 for k in range(-60, 61))
        for dy in (k / 2 for k in range(-60, 61))
        if steel.contains(
            shapely.affinity.translate(ink.envelope, 18 + dx - placed.x, 12 + dy - placed.y)
        )
    )
    way = ((placed.x - 18) ** 2 + (placed.y - 12) ** 2) ** 0.5
    assert way <= reach + 0.3


def test_lines_of_a_drawing_may_stand_in_any_order() -> None:
    sides = [contour((side,), line=k) for k, side in enumerate(box(0, 0, 200, 100))]
    closed: list[Contour] = [replace(c, kind="open", closed=False) for c in reversed(sides)]
    part = drawing(*closed, text("AB", 195.0, 50.0))
    posted = post([part], PLATE)
    assert len(moved(posted)) == 1
    assert read(lettered(posted.text), 10.0) == "AB"


@pytest.mark.parametrize("turned", [False, True])
def test_a_text_stands_beside_contours_that_are_there_twice(turned: bool) -> None:
    outline = box(0, 0, 220, 120)
    other = [c.reversed() for c in reversed(outline)] if turned else [*outline[1:], outline[0]]
    part = drawing(contour(outline), contour(other), text("L-7/b"))
    found = post((part,), PLATE).text
    assert found.count("M3 $1 S1") == post(
        (drawing(contour(outline), text("L-7/b")),), PLATE
    ).text.count("M3 $1 S1")
