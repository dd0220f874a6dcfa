"""Members that several processes read come back as from one, whatever befalls a process."""

import os
import signal
from multiprocessing import active_children
from random import Random

import pytest

from beamcam.readers.ifc import Options, Selection, read
from beamcam.readers.ifc.shares import HEAVY, SHARE, shares
from beamcam.readers.ifc.shares import WORTH as SHARES
from tests.property.ifc_builder import model_text, random_member

WORTH = SHARES * SHARE


def squares(stretch: range) -> list[int]:
    return [n * n for n in stretch]


@pytest.mark.parametrize("workers", [1, 2, 3])
@pytest.mark.parametrize("count", [0, 1, WORTH - 1, WORTH, WORTH + SHARE + 1])
def test_shares_come_in_order_and_leave_nothing_out(count: int, workers: int) -> None:
    given = list(shares(squares, count, workers))

    assert [n for share in given for n in share] == squares(range(count))


def test_a_large_number_is_shared_by_other_processes() -> None:
    first, *others = shares(lambda _: os.getpid(), WORTH, 2)

    assert first == os.getpid()  # which has then read what all share
    assert others
    assert os.getpid() not in others


def test_a_small_number_is_not() -> None:
    assert set(shares(lambda _: os.getpid(), WORTH - 1, 2)) == {os.getpid()}


def test_shares_that_take_long_are_small_and_shared_sooner() -> None:
    _, *others = shares(lambda s: (os.getpid(), len(s)), SHARES * HEAVY, 2, HEAVY)

    assert all(pid != os.getpid() and size == HEAVY for pid, size in others)


@pytest.mark.parametrize("fatal", [SHARE, 3 * SHARE, WORTH - 1])
def test_what_a_killed_process_had_is_done_here(fatal: int) -> None:
    here = os.getpid()

    def deadly(stretch: range) -> list[int]:
        if fatal in stretch and os.getpid() != here:
            os.kill(os.getpid(), signal.SIGKILL)
        return squares(stretch)

    given = list(shares(deadly, WORTH, 2))

    assert [n for share in given for n in share] == squares(range(WORTH))


def test_a_fault_in_a_process_is_raised_here() -> None:
    here = os.getpid()

    def faulty(stretch: range) -> int:
        if os.getpid() != here:
            raise AssertionError(f"at {stretch.start}")
        return 0

    with pytest.raises(AssertionError, match=f"at {SHARE}"):
        list(shares(faulty, WORTH, 2))


def test_who_stops_listening_stops_the_processes() -> None:
    given = shares(squares, 100 * WORTH, 2)
    next(given)
    next(given)
    assert active_children()

    given.close()

    assert not active_children()


@pytest.mark.parametrize("encoding", ["csg", "openings"])
def test_a_model_is_the_same_whoever_reads_it(encoding: str) -> None:
    random = Random(encoding)
    members = [random_member(random, encoding) for _ in range(WORTH + 10)]
    data = model_text(members, encoding, random)[0].encode()
    chosen = Selection(classes=frozenset(["beam"]), marks=frozenset(["nobody"]))

    for selection in (Selection(), chosen):
        alone = read(data, "model.ifc", selection=selection)
        shared = read(data, "model.ifc", selection=selection, options=Options(workers=2))

        assert shared == alone
    assert len(read(data, "model.ifc").parts) == WORTH + 10
