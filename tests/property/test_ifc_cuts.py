"""Whatever is cut off a member: it comes out with the kernel's volume, or something is said.

The part that was read is built again by the geometry kernel from its own numbers and measured
beside the member that went in; ifc_remade.py says how. `python benchmarks/ifc_volumes.py 200` does
so with many more.
"""

from math import cos, radians, sin
from random import Random

import pytest

from beamcam.errors import Severity
from beamcam.readers import Reading
from beamcam.readers.ifc import Options, read
from tests.conftest import sampled
from tests.property.ifc_cut_families import FAMILIES
from tests.property.ifc_cuts import SIZES, Bar, Box, Cuts, Cutter, Half, model_of, walls
from tests.property.ifc_kernel import kernel_volume, meshed, same, volumes
from tests.property.ifc_remade import remade, shape_of

SEEDS = range(2)
MESHED = ("copes", "mitred", "windows", "drilled", "bevelled", "thinned")
CHECKED = Options(kernel=True)


def outcome(bar: Bar, data: bytes, reading: Reading) -> str:
    """What became of a member: read, told with a word, refused; or silently another one."""
    said = sorted({d.code for d in reading.diagnostics if d.severity is not Severity.NOTE})
    if not reading.parts:
        assert said, "a member is neither read nor refused"
        return "refused " + ",".join(said)
    if said:
        return "told " + ",".join(said)
    (part,) = reading.parts
    made, body = remade(part, shape_of(part, bar))
    made.small.element(body)
    pair = volumes(data, made.small.data)
    if pair is None:
        return "read"
    return "read" if same(*pair) else f"SILENTLY {pair[1] - pair[0]:+.3f} of {pair[0]:.2f} cm3"


def met(family: str, seed: int, mesh: bool = False) -> str:
    bar, cutters = FAMILIES[family](Random(f"{family}{seed}"))
    data = model_of(bar, cutters)
    if not kernel_volume(data):
        return "no solid"
    return outcome(bar, data, read(meshed(data) if mesh else data, "m.ifc", options=CHECKED))


@pytest.mark.parametrize("family", sampled(FAMILIES, 3))
def test_no_member_comes_out_otherwise_in_silence(family: str) -> None:
    found = {seed: met(family, seed) for seed in SEEDS}
    assert not [row for row in found.items() if "SILENTLY" in row[1]]


@pytest.mark.parametrize("family", sampled(MESHED, 6))
def test_nor_does_its_mesh(family: str) -> None:
    found = {seed: met(family, seed, mesh=True) for seed in SEEDS}
    assert not [row for row in found.items() if "SILENTLY" in row[1]]


@pytest.mark.parametrize("seed", range(2))
def test_a_bevelled_flat_is_read_from_its_mesh_as_well(seed: int) -> None:
    """Along its edges and at its ends; its section is none of a rectangle then."""
    random = Random(f"flat{seed}")
    bar = Bar("B", 900.0, SIZES["B"])
    h, t = bar.sizes[:2]
    turn = radians(random.uniform(20.0, 50.0))
    land = random.uniform(0.1, 0.6) * t
    along = Half((450.0, h, t - land), (0.0, cos(turn), sin(turn)))
    at_end = Half((900.0, h / 2, t - land), (cos(turn), 0.0, sin(turn)))
    for cutter in (along, at_end):
        data = model_of(bar, [cutter])
        for one in (data, meshed(data)):
            reading = read(one, "m.ifc", options=CHECKED)
            assert outcome(bar, data, reading) == "read"
            assert len([b for c in reading.parts[0].contours for b in c.bevels]) == 1


@pytest.mark.parametrize("code", sampled(["I", "U", "L", "T"], 2))
def test_a_mesh_has_the_radius_of_its_fillets(code: str) -> None:
    """Also where a cut leaves chords of their own in them."""
    bar = Bar(code, 900.0, SIZES[code])
    normal, low, high, width = walls(bar)["v"]
    box = Box((300.0, -5.0, low - 3.0), (400.0, 0.4 * width, high + 3.0))
    (part,) = read(meshed(model_of(bar, [box])), "m.ifc", options=CHECKED).parts
    assert normal == 2
    assert part.profile.radius == pytest.approx(bar.sizes[4], abs=0.01)


def ends(code: str, sizes: tuple[float, float, float, float, float]) -> list[list[Cutter]]:
    """Copes of a beam's end: above, below and both, as long as deep, short and long."""
    h, b, tf = sizes[:3]
    out: list[list[Cutter]] = []
    for long in (10.0, 0.5 * h, 1.5 * h):
        for deep in (tf + 5.0, 0.3 * h, 0.45 * h):
            top = Box((-20.0, h - deep, -20.0), (long, h + 20.0, b + 20.0))
            bottom = Box((-20.0, -20.0, -20.0), (long, deep, b + 20.0))
            out.append(([top], [bottom], [top, bottom])[len(out) % 4 % 3])
    return out


@pytest.mark.parametrize(
    ("code", "every"),
    [("I", 4), *(pytest.param(code, 1, marks=pytest.mark.exhaustive) for code in "IUM")],
)
def test_copes_of_every_proportion_are_read_without_a_word(code: str, every: int) -> None:
    sizes = {
        "I": (300.0, 150.0, 10.7, 7.1, 15.0),
        "U": (200.0, 80.0, 11.0, 7.0, 12.0),
        "M": (200.0, 100.0, 8.0, 8.0, 0.0),
    }[code]
    bar = Bar(code, 1800.0, sizes)
    model = Cuts()
    copes = ends(code, sizes)[::every]
    for cutters in copes:
        model.small.element(model.body(bar, cutters))
    reading = read(model.small.data, "m.ifc", options=CHECKED)
    assert [d for d in reading.diagnostics if d.severity is not Severity.NOTE] == []
    for cutters, part in zip(copes, reading.parts, strict=True):
        made, body = remade(part, bar)
        made.small.element(body)
        pair = volumes(model_of(bar, cutters), made.small.data)
        assert pair is not None
        assert same(*pair), cutters


def test_a_part_that_is_not_the_member_would_be_seen() -> None:
    """The comparison itself: another member's part has another volume."""
    bar, cutters = FAMILIES["copes"](Random("copes1"))
    data = model_of(bar, cutters)
    plain = read(model_of(bar, ()), "m.ifc")
    assert "SILENTLY" in outcome(bar, data, plain)


LIPPED = {0.0: Bar("C", 1200.0, (200.0, 75.0, 2.0, 2.0, 0.0), 20.0),
          3.0: Bar("C", 1200.0, (200.0, 75.0, 3.0, 3.0, 3.0), 20.0)}  # fmt: skip


@pytest.mark.parametrize("radius", LIPPED)
def test_a_mitred_channel_with_lips_is_read_from_its_mesh(radius: float) -> None:
    """The facets of small bends run slantwise from a mitre to the other end, nearly along it."""
    data = model_of(LIPPED[radius], [Half((1100.0, 100.0, 37.5), (cos(0.5), sin(0.5), 0.0))])
    reading = read(meshed(data), "m.ifc", options=CHECKED)
    assert outcome(LIPPED[radius], data, reading) == "read"
    assert reading.parts[0].profile.radius == pytest.approx(radius, abs=0.01)


@pytest.mark.parametrize("radius", sampled(LIPPED, 2))
def test_lips_go_with_their_flange_and_no_part_keeps_them_alone(radius: float) -> None:
    bar = LIPPED[radius]
    for deep, found in ((40.0, "read"), (8.0, "refused ifc-unexplained")):
        data = model_of(bar, [Box((-20.0, -20.0, -20.0), (150.0, deep, 95.0))])
        for one in (data, meshed(data)):
            assert outcome(bar, data, read(one, "m.ifc", options=CHECKED)) == found
