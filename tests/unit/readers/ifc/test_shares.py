"""Members that several processes read come back as from one, whatever befalls a process."""

import os
import signal
from functools import cache
from multiprocessing import active_children
from random import Random

import pytest

from beamcam import processes
from beamcam.budget import InForce, Limits
from beamcam.errors import Severity
from beamcam.readers import Reading
from beamcam.readers.ifc import Options, Selection, member, read, reader
from beamcam.readers.ifc.entities import Unreadable
from beamcam.readers.ifc.reader import SHARE, WORTH, workers_for
from beamcam.readers.ifc.reader import shares as shared_out
from tests.conftest import sampled
from tests.property.ifc_builder import model_text, random_member
from tests.unit.readers.ifc.models import Small

MANY = 4 * SHARE


def squares(stretch: range) -> list[int]:
    return [n * n for n in stretch]


def dead(place: int) -> list[int]:
    return [-place]


def made(count: int, workers: int, each: bool = False) -> list[int]:
    given = shared_out(squares, dead, count, workers, each)
    return [n for share in given for n in share]


@pytest.mark.parametrize("workers", [0, 2, 3])
@pytest.mark.parametrize("count", [0, 1, SHARE, SHARE + 1, 5 * SHARE - 1])
def test_shares_come_in_order_and_leave_nothing_out(count: int, workers: int) -> None:
    assert made(count, workers) == squares(range(count))
    assert made(count // 8, workers, each=True) == squares(range(count // 8))


def test_other_processes_have_all_or_none() -> None:
    def pids(workers: int) -> set[int]:
        return set(shared_out(lambda _: os.getpid(), lambda _: 0, 3 * SHARE, workers, False))

    assert pids(0) == {os.getpid()}
    assert os.getpid() not in pids(2)


def test_what_needs_the_kernel_is_done_in_a_process_of_its_own_that_ends_when_its_time_is_up(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    here = os.getpid()

    def share(stretch: range) -> list[int]:
        (n,) = stretch
        if n % 3 == 0:
            if os.getpid() == here:
                raise member.KernelNeeded
            while n == 3:
                pass
        return [n * n]

    monkeypatch.setattr(InForce, "limits", Limits(member_s=0.1))
    given = [*shared_out(share, dead, 8, 0, False)]
    assert given == [[0], [1], [4], [-3], [16], [25], [36], [49]]


@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_processes_are_for_work_that_pays(method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reader, "start_method", lambda: method)
    for kernel in (False, True):
        worth = WORTH[method, kernel]  # type: ignore[index]
        two = Options(kernel=kernel, workers=2)
        assert (workers_for(two, worth), workers_for(two, worth - 1)) == (2, 0)
        assert workers_for(Options(kernel=kernel), worth) == 0


@pytest.mark.parametrize("fatal", [0, SHARE, 3 * SHARE - 1])
def test_only_the_member_that_kills_is_lost(fatal: int) -> None:
    def deadly(stretch: range) -> list[int]:
        if fatal in stretch:
            os.kill(os.getpid(), signal.SIGKILL)
        return squares(stretch)

    given = list(shared_out(deadly, dead, 3 * SHARE, 2, False))

    assert [n for share in given for n in share] == [
        -n if n == fatal else n * n for n in range(3 * SHARE)
    ]


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="no timers here")
def test_a_member_at_which_the_kernel_never_comes_back_is_lost_alone(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The processor's time ends its process: a library does not look whether it is interrupted."""
    monkeypatch.setattr(InForce, "limits", Limits(member_s=0.02))

    def endless(stretch: range) -> list[int]:
        while SHARE in stretch:
            pass
        return squares(stretch)

    given = list(shared_out(endless, dead, 2 * SHARE, 2, False))
    assert [n for share in given for n in share] == [
        -n if n == SHARE else n * n for n in range(2 * SHARE)
    ]


def test_a_fault_in_a_process_is_raised_here() -> None:
    def faulty(stretch: range) -> int:
        raise AssertionError(f"at {stretch.start}")

    with pytest.raises(AssertionError, match="at 0"):
        list(shared_out(faulty, lambda _: 0, SHARE, 2, False))


def test_who_stops_listening_stops_the_processes() -> None:
    given = shared_out(squares, dead, 100 * SHARE, 2, False)
    next(given)
    assert active_children()

    given.close()  # type: ignore[attr-defined]

    assert not active_children()


def model_of(encoding: str, count: int) -> bytes:
    random = Random(encoding)
    members = [random_member(random, encoding) for _ in range(count)]
    return model_text(members, encoding, random)[0].encode()


@pytest.mark.parametrize("encoding", sampled(["openings", "csg"], 2))
def test_a_model_is_the_same_whoever_reads_it(
    encoding: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(WORTH, ("fork", False), MANY)
    data = model_of(encoding, MANY + 10)
    chosen = Selection(classes=frozenset(["beam"]), marks=frozenset(["nobody"]))

    for selection in (Selection(), chosen):
        alone = read(data, "model.ifc", selection=selection)
        shared = read(data, "model.ifc", selection=selection, options=Options(workers=2))

        assert shared == alone
        assert len(alone.parts) == (MANY + 10) * (selection is not chosen)


@cache
def few() -> tuple[bytes, Reading]:
    """Four short beams of a hole each, and how they are read with the kernel by one process."""
    m = Small()
    for i in range(4):
        hole = m.hole((50.0 + i, 0.0, 60.0), (0, 1, 0), 18.0, 90.0)
        m.element(m.minus(m.extruded(m.ipe300(), 400.0), hole), tag=f"B{i}")
    return m.data, read(m.data, "model.ifc", options=Options(kernel=True))


@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_so_it_is_with_the_kernel(method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    data, alone = few()
    for module in (reader, processes):
        monkeypatch.setattr(module, "start_method", lambda: method)
    monkeypatch.setitem(WORTH, ("spawn", True), 4)
    assert read(data, "model.ifc", options=Options(kernel=True, workers=2)) == alone
    assert len(alone.parts) == 4


def test_a_member_at_which_the_kernel_dies_is_refused_by_name(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    data, alone = few()
    deadly = alone.parts[2]
    real = member.check_kernel

    def check_kernel(*args: object) -> object:
        if args[1].guid == deadly.guid:  # type: ignore[attr-defined]
            os.kill(os.getpid(), signal.SIGKILL)
        return real(*args)  # type: ignore[arg-type]

    monkeypatch.setattr(member, "check_kernel", check_kernel)
    shared = read(data, "model.ifc", options=Options(kernel=True, workers=2))
    assert shared.parts == tuple(p for p in alone.parts if p is not deadly)
    (said,) = [d for d in shared.diagnostics if d.severity is Severity.ERROR]
    assert (said.code, said.source.where) == ("ifc-kernel-died", deadly.guid)


@pytest.mark.parametrize("kernel", [False, True])
def test_where_the_kernel_builds_makes_no_difference(
    kernel: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    model = Small()
    for length in (400.0, 500.0):
        model.element(model.extruded(model.ipe300(), length))

    def body_of(*_: object) -> None:
        raise Unreadable("a definition that is not understood")

    monkeypatch.setattr(member, "body_of", body_of)
    here = read(model.data, "model.ifc", options=Options(kernel=kernel))
    assert [part.length for part in here.parts] == [400.0, 500.0]
    assert read(model.data, "model.ifc", options=Options(kernel=kernel, apart=True)) == here
