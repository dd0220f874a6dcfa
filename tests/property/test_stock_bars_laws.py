"""First fit finds the bars that trying each of them finds, and takes the time of a list."""

import random
from collections import Counter
from math import inf

from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.errors import Diagnostic, PlanError, Source
from beamcam.machine import load
from beamcam.machine.machine import Machine
from beamcam.model.part import EndCuts, Part, Profile
from beamcam.planning.nesting import lay_on_bar
from beamcam.planning.operations.finished_part import Ends, ends_of
from beamcam.planning.stock import Nesting, Rooms, StockBar, first_fit
from tests.conftest import examples

SECTIONS = (
    Profile("I", "IPE200", 200, 100, 8.5, 5.6, 12),
    Profile("I", "IPE160", 160, 82, 7.4, 5, 9),
)
ANGLES = (0.0, 0.0, 20.0, 20.004, 45.0, -30.0, 89.0)
LENGTHS = ((), (6000.0,), (6000.0, 8000.0, 12000.0), (12000.0, 12000.0))


def tried_one_by_one(
    parts: list[Part], machine: Machine, lengths: tuple[float, ...],
    remnants: tuple[float, ...] = (),
) -> Nesting:  # fmt: skip
    """First fit by laying all parts of each bar anew, of remnants first."""
    saw, layout, store = machine.saw, machine.layout, sorted(lengths)
    assert saw is not None
    assert layout is not None
    longest = store[-1] if store else None
    ends: dict[int, Ends] = {}
    bars: list[list[int]] = [[] for _ in remnants]
    own = [*sorted(remnants)]  #: of each bar the length it has; None of those from store
    held: list[float | None] = [*own]
    refusals: list[Diagnostic] = []

    def laid(pieces: list[int], length: float | None) -> StockBar:
        found, _ = lay_on_bar(
            [parts[i] for i in pieces], [ends[i] for i in pieces], layout, saw, length
        )
        return StockBar(tuple(pieces), found.starts, found.bar, length in own)

    for index, part in enumerate(parts):
        try:
            ends[index] = ends_of(part, saw)[0]
            laid([index], None if longest is None else max(longest, *remnants, 0.0))
        except PlanError as error:
            refusals += error.diagnostics
            continue
        for bar, length in zip(bars, held, strict=True):
            first = parts[bar[0]] if bar else part
            if (first.profile, first.grade) != (part.profile, part.grade):
                continue
            try:
                laid([*bar, index], length or longest)
            except PlanError:
                continue
            bar.append(index)
            break
        else:
            try:
                laid([index], longest)
            except PlanError as error:
                refusals += error.diagnostics
                continue
            bars.append([index])
            held.append(None)
    made = []
    for bar, whole in zip(bars, held, strict=True):
        for length in () if not bar else [whole] if whole else store or [None]:
            try:
                made.append(laid(bar, length))
            except PlanError:
                continue
            break
    assert len(made) == sum(map(bool, bars))
    return Nesting(tuple(made), tuple(refusals))


def parts_of(chance: random.Random, count: int) -> list[Part]:
    kinds = [
        Part(
            f"P{number}", chance.choice(SECTIONS),
            chance.choice((chance.uniform(20, 14_000), chance.uniform(100, 900), 1200.0)),
            Source("test", number), grade=chance.choice(("S235", "S355")),
            cuts=EndCuts(*(chance.choice(ANGLES) for _ in range(2))),
        )
        for number in range(chance.randint(1, 12))
    ]  # fmt: skip
    return [chance.choice(kinds) for _ in range(count)]


def machine_of(chance: random.Random) -> Machine:
    machine = load(chance.choice(("beamline", "beamline-pusher")))
    assert machine.saw is not None
    assert machine.layout is not None
    return replace(
        machine,
        saw=replace(
            machine.saw,
            common_cuts=chance.random() < 0.6,
            kerf_along=chance.choice(("normal", "x")),
        ),
        layout=replace(
            machine.layout,
            max_bar=chance.choice((None, 12000.0, 15000.0)),
            min_bar_left=chance.choice((0.0, 700.0)),
            dead_zone=chance.choice((0.0, 300.0)),
        ),
    )


@settings(deadline=None, max_examples=examples(250))
@given(st.integers(0, 10**9))
def test_the_same_bars_as_by_trying_each(seed: int) -> None:
    chance = random.Random(seed)
    parts, machine = parts_of(chance, chance.randint(1, 60)), machine_of(chance)
    lengths = chance.choice(LENGTHS)
    assert first_fit(parts, machine, lengths) == tried_one_by_one(parts, machine, lengths)


@settings(deadline=None, max_examples=examples(150))
@given(
    st.integers(0, 10**9), st.lists(st.sampled_from((1499.0, 3333.0, 7777.0, 13001.0)), max_size=4)
)
def test_remnants_come_first_and_once(seed: int, remnants: list[float]) -> None:
    chance = random.Random(seed)
    machine = machine_of(chance)
    parts = [
        replace(part, profile=SECTIONS[0], grade="S235")
        for part in parts_of(chance, chance.randint(1, 40))
    ]
    lengths = chance.choice(LENGTHS)
    found = first_fit(parts, machine, lengths, remnants)
    assert found == tried_one_by_one(parts, machine, lengths, tuple(remnants))
    used = [bar.account.length for bar in found.bars if bar.is_remnant]
    assert not Counter(used) - Counter(remnants)
    pieces = [piece for bar in found.bars for piece in bar.pieces]
    assert len(pieces) == len(set(pieces))
    if lengths:
        assert {bar.account.length for bar in found.bars if not bar.is_remnant} <= {*lengths}


def test_the_laws_meet_common_cuts_and_refusals() -> None:
    """The random inputs above are of use only if they hold what makes bars differ."""
    nested = refused = several = 0
    for seed in range(60):
        chance = random.Random(seed)
        parts, machine = parts_of(chance, chance.randint(1, 60)), machine_of(chance)
        found = first_fit(parts, machine, chance.choice(LENGTHS))
        nested += any(bar.account.nested > 0 for bar in found.bars)
        refused += bool(found.refusals)
        several += any(len(bar.pieces) > 1 for bar in found.bars)
    assert min(nested, refused, several) >= 10


@given(st.lists(st.tuples(st.integers(0, 40), st.integers(0, 20)), max_size=60))
def test_the_first_room_that_is_large_enough(steps: list[tuple[int, int]]) -> None:
    rooms, plain = Rooms(), []
    for at, room in steps:
        if at < len(plain):
            plain[at] = float(room)
            rooms.change(at, room)
        else:
            plain.append(float(room))
            rooms.add(room)
        for need in (0, room, room + 1, inf):
            for begin in (0, at, len(plain)):
                wanted = next((i for i in range(begin, len(plain)) if plain[i] >= need), None)
                assert rooms.first(need, begin) == wanted


def test_many_pieces_ask_each_bar_for_its_room_seldom() -> None:
    """Steps are counted, since no test may measure time: those of a list times its logarithm."""
    asked = 0

    class Counted(Rooms):
        def first(self, need: float, begin: int) -> int | None:
            nonlocal asked
            asked += 1
            return super().first(need, begin)

    chance = random.Random(5)
    kinds = [
        Part(f"P{i}", SECTIONS[0], chance.uniform(300, 6000), Source("test", i)) for i in range(100)
    ]
    parts = [part for part in kinds for _ in range(30)]
    import beamcam.planning.stock as module

    kept, module.Rooms = module.Rooms, Counted  # type: ignore[misc]
    try:
        bars = first_fit(parts, load("beamline"), (12000.0,)).bars
    finally:
        module.Rooms = kept  # type: ignore[misc]
    assert len(bars) > 500
    assert asked < 1.2 * len(parts)
