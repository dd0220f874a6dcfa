"""A model's member, its DSTV file, and what that is read as: one solid, of the same hand.

The members are chiral: holes off the middle, a cope on one side, skew ends. Beside them stand two
solids that have nothing of the reader: the geometry kernel's of the model, and manifold3d's of the
part that comes out of the DSTV file. They are laid on one another in every way that a body can be
turned, and in every way that its mirror image can.
"""

from functools import cache
from itertools import permutations, product
from math import cos, radians, sin
from random import Random
from typing import Any

import numpy as np
import pytest

from beamcam.model.part import Part
from beamcam.readers import dstv
from beamcam.readers.ifc import Options, read
from beamcam.solid.kernel import kernel
from beamcam.solid.part_solid import part_solid
from beamcam.writers.dstv import write
from benchmarks.ifc_anyhow import Anyhow, some_way
from tests.conftest import sampled
from tests.property.ifc_cuts import SIZES, Bar, Box, Cutter, Half, Round, walls
from tests.property.ifc_kernel import facets

SEEDS = range(60)
CODES = ("I", "U", "L", "T", "M", "RO", "B")
OFF = (
    0.004  #: share of a member by which facets and fillets of copes let two solids differ, at most
)


def chiral(seed: int) -> tuple[Bar, list[Cutter]]:
    """A member that no turn lays on its mirror image."""
    code = CODES[seed % len(CODES)]
    random = Random(f"chain{seed}")
    factor = random.choice((1.0, 1.4))
    h, b, tf, tw, r = (round(v * factor, 1) for v in SIZES[code])
    bar = Bar(code, float(random.randint(600, 1200)), (h, b, tf, tw, r))
    turn, roll = radians(random.uniform(10, 35)), radians(random.choice((0, 90, 30, 200)))
    if code == "RO":
        roll = radians(random.uniform(20, 70))
    if code == "B":
        roll = 0.0  # its ends are sawn square to its face
    lean = sin(turn) * cos(roll), sin(turn) * sin(roll)
    cutters: list[Cutter] = [Half((bar.length - h / 2, h / 2, b / 2), (cos(turn), *lean))]
    if code == "RO":
        cutters.append(Round((0.3 * bar.length, -20.0, b / 2), 1, 0.15 * h, h + 40.0))
        cutters.append(Round((0.45 * bar.length, h / 2, -20.0), 2, 0.2 * h, b + 40.0))
        return bar, cutters
    if code == "B":  # which is its own mirror image but for a bevel
        cutters.append(Half((bar.length / 2, h, 0.6 * b), (0.0, cos(turn), sin(turn))))
    for face, (along, low, high, width) in walls(bar).items():
        if face == "v" or (face == "u" and code != "T") or (code, face) == ("T", "o"):
            x, q = random.uniform(0.35, 0.45) * bar.length, 0.8 * width
            at = (x, low - 3.0, q) if along == 1 else (x, q, low - 3.0)
            cutters.append(Round(at, along, random.choice((9.0, 13.0)), high - low + 6.0))
    deep = random.uniform(tf + r + 5.0, 0.4 * h)
    y = (-20.0, deep) if random.random() < 0.5 else (h - deep, h + 20.0)
    z = (-20.0, (b - tw) / 2 if code == "I" and random.random() < 0.5 else b + 20.0)
    long = random.uniform(20, 80)
    cutters.append(Box((-20.0, y[0], z[0]), (long, y[1], z[1])))
    return bar, cutters


@cache
def chain(seed: int) -> tuple[Any, Part]:
    """The kernel's solid of a model, and the part of the DSTV file of what is read of it."""
    bar, cutters = chiral(seed)
    random = Random(seed)
    data = Anyhow(some_way(random), random).whole(bar, cutters)
    found = read(data, "m.ifc", options=Options(kernel=True))
    assert not found.refused, [str(d) for d in found.diagnostics]
    (part,) = found.parts
    (again,) = dstv.read(write(part).encode(), "part.nc1").parts
    points, triangles = (np.array(rows) for rows in facets(data, angle=0.08))
    m = kernel()
    solid = m.Manifold(m.Mesh64(points, triangles.astype(np.uint64)))
    if solid.volume() < 0.0:  # as the kernel leaves what a mirror in the model turned inside out
        solid = m.Manifold(m.Mesh64(points, triangles[:, ::-1].astype(np.uint64)))
    assert solid.status() == m.Error.NoError
    return solid, again


def apart(one: Any, other: Any) -> tuple[float, float]:
    """The least share by which two solids differ, of all turns and of all mirrored turns."""
    best = {1: 1.0, -1: 1.0}
    low, size = _box(one)
    for axes, signs in product(permutations(range(3)), product((1, -1), repeat=3)):
        turn = np.zeros((3, 3))
        turn[range(3), axes] = signs
        laid = other.transform(np.column_stack((turn, np.zeros(3))))
        its_low, its_size = _box(laid)
        if np.abs(size - its_size).max() > 1.0:
            continue
        laid = laid.translate(low + size / 2 - its_low - its_size / 2)
        differ = one.volume() + laid.volume() - 2.0 * (one ^ laid).volume()
        hand = round(float(np.linalg.det(turn)))
        best[hand] = min(best[hand], differ / one.volume())
    return best[1], best[-1]


def _box(solid: Any) -> tuple[Any, Any]:
    box = np.array(solid.bounding_box())
    return box[:3], box[3:] - box[:3]


@pytest.mark.parametrize("seed", sampled(SEEDS, 9))  # each of the codes once
def test_a_chiral_member_comes_out_of_its_dstv_file_as_it_was_modelled(seed: int) -> None:
    solid, again = chain(seed)
    own, mirrored = apart(solid, part_solid(again))
    assert own < OFF
    assert mirrored > 2 * own


@pytest.mark.parametrize("seed", sampled([0, 9, 18], 3))
def test_a_mirrored_part_would_be_seen(seed: int) -> None:
    solid, again = chain(seed)
    own, mirrored = apart(solid, part_solid(again).mirror((0.0, 0.0, 1.0)))
    assert own > 2 * mirrored
