"""Breps that are no members: each form is looked at once, by its own faces."""

from random import Random

import pytest

from beamcam.readers.ifc import Options, member, read
from benchmarks.bent_accessories import add_bent, bent
from tests.property.ifc_builder import Member, Step, facets
from tests.unit.readers.ifc.models import Small

CHECKED = Options(kernel=True)
BEAM = Member("I", (200.0, 100.0, 8.5, 5.6), 600.0, ((0, 0), (0, 0)), ())


def written(step: Step, placement: str, *seeds: int) -> None:
    for k, seed in enumerate(seeds):
        add_bent(step, placement, bent(Random(seed)), f"S{k}")


def called(monkeypatch: pytest.MonkeyPatch, name: str) -> list[str]:
    """The calls of a function of the room."""
    calls: list[str] = []
    real = getattr(member, name)

    def counted(*args: object) -> object:
        calls.append(name)
        return real(*args)

    monkeypatch.setattr(member, name, counted)
    return calls


@pytest.mark.parametrize("seed", range(6))
def test_a_bent_accessory_is_refused_by_its_own_faces(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    m = Small()
    written(m.step, m.placement, seed)
    kernel = called(monkeypatch, "read_kernel")
    found = read(m.data, "m.ifc", options=CHECKED)
    assert found.parts == ()
    assert found.diagnostics[0].code in ("ifc-section", "ifc-unexplained")
    assert not kernel


def test_equal_shells_are_read_once_and_each_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    m = Small()
    straight = [face[0] for face in facets(BEAM)]
    written(m.step, m.placement, 1, 2, 1, 1)
    for mark in ("B1", "B2"):
        add_bent(m.step, m.placement, straight, mark)
    shells = called(monkeypatch, "read_shell")
    found = read(m.data, "m.ifc", options=CHECKED)
    assert len(shells) == 3
    refused = [d for d in found.diagnostics if d.code in ("ifc-section", "ifc-unexplained")]
    assert len({d.source.where for d in refused}) == 4
    assert refused[0].message == refused[2].message == refused[3].message
    first, second = found.parts
    assert (first.mark, second.mark) == ("B1", "B2")
    assert {f.source for f in second.features} <= {second.source}
    assert (first.length, first.cuts) == (second.length, second.cuts)
