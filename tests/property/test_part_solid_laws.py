"""The solid of a part that was read has the volume of the member, by the kernel of ifcopenshell."""

from random import Random

import pytest

from beamcam.errors import Severity
from beamcam.readers.ifc import Options, read
from beamcam.solid.kernel import CHORD
from beamcam.solid.part_solid import part_solid
from tests.property.ifc_cut_families import FAMILIES
from tests.property.ifc_cuts import model_of
from tests.property.ifc_kernel import kernel_volume

#: Of each family the first members that are read without a remark.
SEEDS = 2


@pytest.mark.parametrize("family", sorted(FAMILIES))
def test_volumes_are_the_kernels(family: str) -> None:
    measured = 0
    for seed in range(SEEDS):
        bar, cutters = FAMILIES[family](Random(f"{family}{seed}"))
        data = model_of(bar, cutters)
        volume = kernel_volume(data)
        reading = read(data, "m.ifc", options=Options(kernel=True))
        said = [d for d in reading.diagnostics if d.severity is not Severity.NOTE]
        if not volume or said or len(reading.parts) != 1:
            continue
        (part,) = reading.parts
        # A round bar's chords take 4/3 of CHORD over its radius off its section.
        chords = 2.7 * CHORD / part.profile.height if part.profile.code == "RU" else 0.0
        solid = part_solid(part).volume() / 1000
        assert solid == pytest.approx(volume, rel=3e-4 + chords, abs=0.1), seed
        measured += 1
    assert measured
