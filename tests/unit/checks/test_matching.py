"""Several holes at one place: each is found, and is told apart from what is nearly it."""

import random

import pytest
from msgspec.structs import replace

from beamcam.checks.bars import verify
from beamcam.errors import PlanError, Source, errors_in
from beamcam.machine import load
from beamcam.model.part import Hole, HoleKind, Part, Profile, Slot
from beamcam.model.plan import SKIP_NAMES
from beamcam.pipeline import post

UPN200 = Profile("U", "UPN200", 200.0, 75.0, 11.5, 8.5, 11.5)
IPE300 = Profile("I", "IPE300", 300.0, 150.0, 10.7, 7.1, 15.0)
L150 = Profile("L", "L150*100*12", 150.0, 100.0, 12.0, 12.0, 12.0)


def hole(
    face: str, x: float, y: float, diameter: float, kind: HoleKind = "through",
    depth: float | None = None, angle: float | None = None,
) -> Hole:  # fmt: skip
    return Hole(face, x, y, diameter, Source("p", 1), depth, kind, angle)


def part(profile: Profile, *holes: Hole) -> Part:
    found = tuple(replace(h, source=Source("p", line)) for line, h in enumerate(holes, 20))
    return Part("P", profile, 1500.0, Source("p", 1), features=found)


@pytest.mark.parametrize(("machine", "made"), [
    ("beamline", part(UPN200, hole("o", 200, 40, 14), hole("o", 200, 40, 22, "blind", 4.0))),
    ("beamline", part(UPN200, hole("o", 200, 40, 22, "blind", 4.0), hole("o", 200, 40, 14))),
    ("beamline", part(
        UPN200, hole("o", 300, 40.05, 22, "blind", 6.0), hole("o", 300, 40, 14),
        hole("u", 300, 40.05, 14),
    )),
    ("beamline", part(
        IPE300, hole("o", 200, 30, 22, "blind", 4.0), hole("u", 200.05, 30, 22, "blind", 4.0),
        hole("o", 200.05, 30, 17.5), hole("u", 200, 30, 17.5),
    )),
    ("beamline-pusher", part(
        IPE300, hole("o", 200, 40, 14), hole("u", 200, 40, 14), hole("o", 200, 40, 16, "thread"),
    )),
    ("beamline-pusher", part(
        L150, hole("o", 300, 40.05, 9), hole("u", 300, 40.05, 22, "countersink", None, 90.0),
    )),
])  # fmt: skip
def test_holes_at_one_place_are_each_found(machine: str, made: Part) -> None:
    loaded = load(machine)
    text = post((made,), loaded, bar=6000.0).text  # is read back
    for f, feature in enumerate(made.features):
        assert isinstance(feature, Hole)
        other = replace(feature, y=feature.y + 0.5)
        features = (*made.features[:f], other, *made.features[f + 1 :])
        assert errors_in(verify(text, (replace(made, features=features),), loaded))


@pytest.mark.parametrize("machine", ["beamline", "beamline-annex", "beamline-pusher"])
def test_whatever_is_planned_at_one_place_is_read_back(machine: str) -> None:
    rng = random.Random(11)
    loaded = load(machine)
    posted = 0
    for _ in range(200):
        holes = [crowded(rng, machine) for _ in range(rng.randrange(2, 7))]
        made = part(rng.choice((UPN200, IPE300, L150)), *holes)
        try:
            plan = post((made,), loaded, bar=6000.0, skips=SKIP_NAMES).plan
        except PlanError:
            continue
        posted += any(o.how in ("made", "merged") for o in plan.outcomes)
    assert posted > 30


def crowded(rng: random.Random, machine: str) -> Hole:
    kinds: tuple[HoleKind, ...] = ("through", "through", "blind")
    if machine == "beamline-pusher":
        kinds = ("through", "blind", "thread", "countersink", "mark", "through")
    kind = rng.choice(kinds)
    diameter = rng.choice((12.0, 16.0) if kind == "thread" else (9.0, 14.0, 14.0, 17.5, 22.0, 60.0))
    angle = rng.choice((90.0, None)) if kind == "countersink" else None
    depth = None
    if kind in ("blind", "thread") or (kind == "countersink" and angle is None):
        depth = rng.choice((4.0, 6.0))
    x, y = rng.choice((300.0, 300.0, 300.05, 300.3)), rng.choice((40.0, 40.05))
    return hole(rng.choice("vou"), x, y, diameter, kind, depth, angle)


@pytest.mark.parametrize("times", [1, 2])
def test_a_hole_where_a_mill_goes_in_is_the_part_s(times: int) -> None:
    """The end of a slot may be drilled before it is milled; a hole of the part there has to be."""
    slot = Slot("v", 500.0, 150.0, 100.0, 20.0, 0.0, 0.0, Source("p", 1))
    made = replace(part(IPE300), features=(slot,) * times + (hole("v", 490, 150, 14),))
    assert post([made], load("beamline-pusher")).text
