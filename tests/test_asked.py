"""What was asked for, counted and laid out by the read-back alone, and held against the planner."""

import cmath
from collections import Counter
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam import pipeline
from beamcam.checks.job import job_faults, pieces_asked
from beamcam.checks.sheets.required_layout import laid_out
from beamcam.errors import Source, VerifyError
from beamcam.geometry.curves import Arc, Line
from beamcam.machine import load
from beamcam.machine.overlay import with_torch
from beamcam.model.part import Bend, Contour, Hole, Part, Profile, Slot, TextMark
from beamcam.model.request import Job, Request, Share, pieces_of
from beamcam.pipeline import begin, finished, shares_of
from beamcam.planning.contours.plate import laid
from benchmarks import asked_liars
from tests.conftest import SAMPLES, examples
from tests.runs import call

S = Source("a.nc1", 1)
UPN = Profile("U", "UPN200", 200.0, 75.0, 11.5, 8.5, 11.5)
LINE, TABLE = load("beamline"), load("plate-linuxcnc")


def bar_part(mark: str, length: float, quantity: int = 1) -> Part:
    hole = Hole("v", length / 2, 100.0, 18.0, S)
    return Part(mark, UPN, length, Source(f"{mark}.nc1", 1), quantity, features=(hole,))


def corner_plate(*features: object, length: float = 300.0, width: float = 200.0) -> Part:
    """An L, so that no mirror image of it is itself."""
    corners = [(0, 0), (length, 0), (length, 80), (120, 80), (120, width), (0, width)]
    sides = tuple(map(Line, corners, [*corners[1:], corners[0]]))
    profile = Profile("B", "PL10", width, 0.0, 0.0, 10.0)
    contour = Contour("v", "outer", sides, S)
    return Part("L1", profile, length, S, features=(contour, *features))  # type: ignore[arg-type]


quantities = st.none() | st.just("file") | st.integers(1, 5)


@given(st.lists(st.integers(1, 4), min_size=1, max_size=5), quantities)
def test_pieces_are_counted_as_the_words_say(numbers: list[int], quantity: object) -> None:
    parts = tuple(bar_part(f"P{k}", 1000.0, number) for k, number in enumerate(numbers))
    request = Request(parts, LINE, quantity=quantity)  # type: ignore[arg-type]
    one_each = {None: 1, "file": None}.get(quantity, quantity)  # type: ignore[call-overload]
    expected = {k: n if one_each is None else one_each for k, n in enumerate(numbers)}
    assert pieces_asked(request) == expected
    assert Counter(pieces_of(request)) == expected


def test_a_line_without_a_saw_makes_one_of_each_with_every_run() -> None:
    request = Request((bar_part("A", 3000.0, 4),), replace(LINE, saw=None), quantity="file")
    assert pieces_asked(request) == {0: 1}
    assert pieces_of(request) == (0,)


@given(
    st.lists(st.tuples(st.integers(300, 5000), st.integers(1, 4)), min_size=1, max_size=5),
    st.data(),
)
def test_programs_that_are_not_what_was_asked_for(
    parts: list[tuple[int, int]], data: st.DataObject
) -> None:
    """The planner's shares are right; one piece more, less, exchanged or moved is not."""
    made = tuple(bar_part(f"P{k}", length, n) for k, (length, n) in enumerate(parts))
    request = Request(made, LINE, stock=(6000.0, 12000.0), quantity="file")
    true = [
        Job(request, share.pieces, share.lengths[0]) for share in shares_of(request)
    ]  # fmt: skip
    assert job_faults(request, true) == ()
    at = data.draw(st.integers(0, len(true) - 1))
    job = true[at]

    def codes(pieces: tuple[int, ...], bar: float | None = job.bar) -> set[str]:
        one = Job(request, pieces, bar)
        return {said.code for said in job_faults(request, [*true[:at], one, *true[at + 1 :]])}

    assert codes(job.pieces[1:]) == codes((*job.pieces, job.pieces[-1])) == {"verify-pieces"}
    assert codes((*job.pieces, len(made))) == {"verify-pieces"}
    assert codes((*job.pieces[:-1], job.pieces[-1] + 1)) == {"verify-pieces"}
    assert codes(job.pieces, 9000.0) == codes(job.pieces, None) == {"verify-stock-bar"}
    back = job.pieces[::-1]
    assert codes(back) == (set() if len(set(back)) == 1 else {"verify-piece-order"})


def test_what_is_said_of_another_order_and_another_bar() -> None:
    made = bar_part("A", 3000.0, 1), bar_part("B", 2000.0, 1)
    request = Request(made, LINE, stock=(6000.0,), quantity="file")
    order, bar = map(str, job_faults(request, [Job(request, (1, 0), 9000.0)]))
    assert "error verify-piece-order: found A behind B in a program; expected the order" in order
    assert "error verify-stock-bar: found a program for a bar of 9000 mm; expected 6000 mm" in bar


def test_a_planner_that_drops_a_piece_posts_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    request = Request((bar_part("A", 3000.0, 3),), LINE, quantity="file", stock=(12000.0,))
    assert sum(len(begun.job.pieces) for begun in begin(request)) == 3
    true = pipeline.shares_of
    monkeypatch.setattr(
        pipeline, "shares_of",
        lambda *asked: [Share(s.pieces[:-1], s.lengths) for s in true(*asked)],
    )  # fmt: skip
    with pytest.raises(VerifyError, match=r"verify-pieces: found 2 of A .* expected 3"):
        begin(request)


FEATURES = (
    Hole("v", 40.0, 30.0, 22.0, S),
    Slot("v", 200.0, 40.0, 20.0, 30.0, 0.0, 25.0, S),
    Contour("v", "inner", (Arc((60.0, 140.0), 25.0, 0.0, 360.0),), S),
)
asked_layouts = st.fixed_dictionaries({
    "mirror": st.sampled_from(["none", "x", "y"]),
    "rotate": st.sampled_from([0.0, 90.0, 180.0, 270.0, 30.0, -17.5]),
    "copies": st.tuples(st.integers(1, 3), st.integers(1, 2)),
    "spacing": st.sampled_from([5.0, 12.5]),
})  # fmt: skip


@settings(max_examples=examples(60), deadline=None)
@given(asked_layouts, st.booleans())
def test_where_parts_lie_by_complex_numbers(how: dict[str, object], plain: bool) -> None:
    """Planner and read-back, each against p -> (mirror, then turn about the middle, then step)."""
    part = corner_plate(*FEATURES)
    if plain:  # a plate that is its length and width alone
        part = replace(part, features=(FEATURES[0],))
    torch = with_torch(TABLE, **how).torch
    assert torch is not None
    (theirs, _), ((ours,), said) = laid((part,), torch), laid_out((part,), torch)
    assert said == []
    middle, turn = complex(150, 100), cmath.exp(1j * cmath.pi * torch.rotate / 180)

    def at(point: complex) -> complex:
        p = point - middle
        p = {"none": p, "x": -p.conjugate(), "y": p.conjugate()}[torch.mirror]
        return p * turn + middle

    outline = [0, 300, 300 + 200j, 200j] if plain else [0, 300, 300 + 80j, 120 + 200j, 200j]
    corners = [at(complex(p)) for p in outline]
    size = complex(
        max(p.real for p in corners) - min(p.real for p in corners) + torch.spacing,
        max(p.imag for p in corners) - min(p.imag for p in corners) + torch.spacing,
    )
    columns, rows = torch.copies
    holes = [
        at(40 + 30j) + complex(k * size.real, n * size.imag)
        for n in range(rows) for k in range(columns)
    ]  # fmt: skip
    for made in (theirs[0], ours):
        if torch.mirror == "none" and not torch.rotate and torch.copies == (1, 1):
            continue  # the part as it is
        assert len(made.features) == columns * rows * (2 if plain else 4)
        found = [complex(hole.x, hole.y) for hole in made.holes]
        assert all(abs(a - b) < 1e-6 for a, b in zip(found, holes, strict=True))
        assert abs(made.length - (columns * size.real - torch.spacing)) < 1e-6
        assert abs(made.profile.height - (rows * size.imag - torch.spacing)) < 1e-6


@pytest.mark.parametrize(
    ("feature", "what"),
    [
        (TextMark("v", 20, 20, 0.0, 5.0, "A", S), "textmark"),
        (Bend((0.0, 0.0), (0.0, 50.0), 90.0, 5.0, S), "bend"),
    ],
)
def test_what_cannot_lie_otherwise_is_refused_by_the_read_back(feature: object, what: str) -> None:
    torch = with_torch(TABLE, mirror="x").torch
    _, (said,) = laid_out((corner_plate(feature),), torch)
    assert (said.code, what in said.message) == ("verify-sheet-laid", True)


def test_several_sheets_together_are_what_was_asked_for() -> None:
    request = Request((replace(corner_plate(*FEATURES), quantity=5),), TABLE, quantity="file")
    small = replace(request, machine=with_torch(TABLE, sheet_size=(700.0, 500.0)))
    begun = begin(small)
    assert len(begun) == 2
    assert sum(len(finished(one).plan.pieces) for one in begun) == 5


@pytest.mark.parametrize("every", [9, pytest.param(1, marks=pytest.mark.exhaustive)])
def test_no_lie_about_the_job_is_posted(every: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(asked_liars, "LAYOUTS", asked_liars.LAYOUTS[::every])
    lies = asked_liars.told()
    assert lies.missed == []
    assert sum(lies.made.values()) > 300 // (every + 2)


def test_a_warning_that_no_machine_changes_starts_no_search(tmp_path: Path) -> None:
    words = ["post", str(SAMPLES / "dstv/tie.nc1"), "--strict", "-o", str(tmp_path / "job.gcode")]
    done = call(*words, status=1)
    assert [line.split()[2] for line in done.stderr.splitlines()] == ["plan-quantity:"]
    assert [*tmp_path.iterdir()] == []
