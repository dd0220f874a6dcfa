"""The kernel as a second opinion."""

import subprocess
import sys
from collections.abc import Callable, Mapping
from typing import Any

import pytest
from msgspec.structs import replace

from beamcam.errors import Source
from beamcam.readers.ifc import Options, kernel, read
from beamcam.readers.ifc.entities import Entity, Model
from beamcam.readers.ifc.kernel import FACETED, ROUNDER, Built, built
from beamcam.readers.ifc.marks import Data
from beamcam.readers.ifc.same_solid import Differences
from tests.unit.readers.ifc.models import Small, opened


def drilled(**properties: str) -> Small:
    m = Small()
    body = m.minus(m.extruded(m.ipe300(), 2000.0), m.hole((500, -20, 0), (0, 1, 0), 22, 40))
    element = m.element(body)
    if properties:
        m.properties(element, "Tekla Quantity", **properties)
    return m


def solid(**properties: str) -> bytes:
    """The same member without its hole, as a kernel that lost it would build."""
    m = Small()
    m.element(m.extruded(m.ipe300(), 2000.0))
    return m.data


CHECKED = Options(kernel=True)


def test_agreement_is_silent() -> None:
    found = read(drilled().data, "m.ifc", options=CHECKED)
    assert [d.code for d in found.diagnostics] == ["ifc-ledger"]
    assert len(found.parts) == 1


def patched(monkeypatch: pytest.MonkeyPatch, made: Callable[..., Built]) -> None:
    """Let the kernel build its solids by `made`, and the stock as ever."""

    def build(model: Model, element: Entity, asked: Mapping[str, Any] = kernel.FINE) -> Built:
        return (built if asked is kernel.STOCK else made)(model, element, asked)

    monkeypatch.setattr(kernel, "built", build)


@pytest.fixture
def losing(monkeypatch: pytest.MonkeyPatch) -> None:
    """A kernel that loses every cut."""

    def lost(*_: object) -> Built:
        other = opened(solid())
        return built(other, other.file.by_type("IfcBeam")[0])

    patched(monkeypatch, lost)


@pytest.mark.usefixtures("losing")
def test_a_hole_that_the_kernel_loses_refuses_the_member() -> None:
    found = read(drilled().data, "m.ifc", options=CHECKED)
    (said,) = [d for d in found.diagnostics if d.code == "ifc-unexplained"]
    assert "cm3 more on face v at x 489.0 to 511.0" in said.message
    assert found.parts == ()
    forced = read(drilled().data, "m.ifc", options=replace(CHECKED, force=True))
    assert len(forced.parts) == 1


@pytest.mark.usefixtures("losing")
def test_the_net_weight_decides_against_the_kernel() -> None:
    data = drilled(NetWeight="IFCMASSMEASURE(84.46)").data
    found = read(data, "m.ifc", options=CHECKED)
    (said,) = [d for d in found.diagnostics if d.code == "ifc-kernel-denied"]
    assert "Tekla Quantity.NetWeight" in said.message
    assert len(found.parts) == 1


def test_an_error_in_the_log_refuses_the_member(monkeypatch: pytest.MonkeyPatch) -> None:
    def failing(model: Model, element: Entity, asked: Mapping[str, Any]) -> Built:
        return replace(built(model, element, asked), error="[error] [GEO027] cannot build")

    patched(monkeypatch, failing)
    found = read(drilled().data, "m.ifc", options=CHECKED)
    (said,) = [d for d in found.diagnostics if d.code == "ifc-kernel-log"]
    assert "GEO027" in said.message


def test_a_slot_is_built_though_the_kernel_cannot() -> None:
    """A radius of half the side makes the kernel drop the slot; the file stays as it was."""
    m = Small()
    profile = m.add(f"IFCROUNDEDRECTANGLEPROFILEDEF(.AREA.,$,{m.flat},62.,22.,11.)")
    at = m.step.axes((800, -20, 0), (0, 1, 0), (1, 0, 0))
    m.element(m.minus(m.extruded(m.ipe300(), 2000.0), m.extruded(profile, 40.0, at)))
    found = read(m.data, "m.ifc", options=CHECKED)
    assert [d.code for d in found.diagnostics] == ["ifc-ledger"]
    (slot,) = found.parts[0].features
    assert (slot.length, slot.diameter) == (40.0, 22.0)  # type: ignore[union-attr]


def test_only_the_slots_of_the_member_are_made_less_round() -> None:
    """In the kernel's copy, and no less round the second time."""
    m = Small()
    for diameter in (22.0, 26.0):
        profile = m.add(
            f"IFCROUNDEDRECTANGLEPROFILEDEF(.AREA.,$,{m.flat},62.,{diameter},{diameter / 2})"
        )
        at = m.step.axes((800, -20, 0), (0, 1, 0), (1, 0, 0))
        m.element(m.minus(m.extruded(m.ipe300(), 2000.0), m.extruded(profile, 40.0, at)))
    model = opened(m.data)
    first, _ = model.file.by_type("IfcBeam")
    for _ in range(2):
        built(model, first)
        slots = model.file.opened.by_type("IfcRoundedRectangleProfileDef")
        assert [s.RoundingRadius for s in slots] == [11.0 * ROUNDER, 13.0]
    own = model.file.by_type("IfcRoundedRectangleProfileDef")
    assert [s.RoundingRadius for s in own] == [11.0, 13.0]


def test_facets_and_surfaces_of_one_solid_are_those_of_two() -> None:
    model = opened(drilled().data)
    (element,) = model.file.by_type("IfcBeam")
    found = built(model, element, {})
    finer = built(model, element)
    assert 26 < found.shell.count <= finer.shell.count
    assert found.volume == finer.volume
    assert found.shell.cylinders == built(model, element, {}).shell.cylinders != ()


def test_a_form_that_the_kernel_cannot_give_is_no_solid(monkeypatch: pytest.MonkeyPatch) -> None:
    from ifcopenshell import ifcopenshell_wrapper as wrapper

    def failing(solid: object) -> object:
        raise RuntimeError("no triangles")

    for name in FACETED:
        monkeypatch.setattr(wrapper, name, failing, raising=False)
    found = read(drilled().data, "m.ifc", options=CHECKED)
    (said,) = [d for d in found.diagnostics if d.severity.value == "error"]
    assert said.code == "ifc-kernel"
    assert "no solid (no solid by the kernel (no triangles))" in said.message


def test_a_kernel_without_a_solid_is_no_witness(monkeypatch: pytest.MonkeyPatch) -> None:
    from beamcam.readers.ifc.entities import Unreadable

    def nothing(*_: object) -> Built:
        raise Unreadable("an empty solid by the kernel")

    patched(monkeypatch, nothing)
    found = read(drilled().data, "m.ifc", options=CHECKED)
    assert [d.code for d in found.diagnostics if d.severity.value == "error"] == ["ifc-kernel"]


def test_a_volume_that_is_off_by_more_than_half_a_percent_refuses_the_member() -> None:
    source = Source("m.ifc")
    (near,) = Differences(volume=1e5, expected=1e5 - 140.0).diagnostics(source)
    (far,) = Differences(volume=1e5, expected=1e5 + 600.0).diagnostics(source)
    assert Differences(volume=1e5, expected=1e5 - 40.0).diagnostics(source) == ()
    assert (near.code, near.severity.value) == ("ifc-volume", "warning")
    assert (far.code, far.severity.value) == ("ifc-volume-off", "error")
    assert "found a volume of 100.00 cm3 in the model; expected 100.60 cm3" in far.message


def test_rounded_lengths_and_gross_weights_are_no_contradiction() -> None:
    data = drilled(Length="IFCLENGTHMEASURE(2000.4)", NetWeight="IFCMASSMEASURE(84.5)").data
    assert len(read(data, "m.ifc").parts) == 1


def test_an_empty_data_says_nothing() -> None:
    found = read(drilled().data, "m.ifc")
    assert found.parts[0].source == Source("m.ifc", where=found.parts[0].guid)
    assert Data().number("length") == ("", 0.0)


INTERRUPTED = """
import builtins, os, signal
from beamcam.readers.ifc.kernel import _kernel

real = builtins.__import__

def interrupting(name, globals=None, locals=None, fromlist=(), level=0):
    if name == "stream" and level == 1:  # in ifcopenshell's own `try` without a name
        os.kill(os.getpid(), signal.SIGINT)
    return real(name, globals, locals, fromlist, level)

builtins.__import__ = interrupting
try:
    _kernel()
    print("went on")
except KeyboardInterrupt:
    print("stopped")
"""


def test_an_interrupt_while_the_kernel_is_loaded_is_not_lost() -> None:
    done = subprocess.run(
        [sys.executable, "-c", INTERRUPTED], capture_output=True, text=True, check=True
    )
    assert done.stdout == "stopped\n"
