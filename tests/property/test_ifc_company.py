"""A member is the same part with the same messages alone, in company, in any order."""

from functools import cache
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from beamcam.readers.ifc import Options, read
from tests.conftest import examples
from tests.property.ifc_cut_families import FAMILIES, some_bar
from tests.property.ifc_cuts import SIZES, Bar, Box, Cuts, Cutter, Round

#: Members of one section that are read alike and are not alike: what is cut inside a wall or out
#: of a root fillet shows at none of the levels at which walls are looked at.
BEAM = Bar("I", 1500.0, SIZES["I"])
INSIDE: dict[str, list[Cutter]] = {
    "plain": [],
    "far": [Box((2000.0, 0.0, 0.0), (2100.0, 300.0, 150.0))],
    "bore": [Box((700.0, 292.0, -10.0), (708.0, 297.0, 160.0))],
    "other bore": [Box((900.0, 292.0, -10.0), (912.0, 297.0, 160.0))],
    "fillet": [Box((-10.0, 12.0, 65.0), (1600.0, 16.0, 70.0))],
    "hole": [Round((750.0, 150.0, 0.0), 2, 22.0, 150.0)],
}
#: Tubes, of which the outside is the same and the inside is not.
TUBE = Bar("RO", 900.0, (60.3, 60.3, 2.9, 2.9, 0.0))
SLOT = Box((-9.0, -9.0, 25.0), (60.0, 70.0, 35.0))
TUBES: dict[str, list[Cutter]] = {
    "slot": [SLOT],
    "slot and groove": [SLOT, Box((200.0, 30.0, 25.0), (400.0, 58.0, 35.0))],
    "saddle": [SLOT, Round((900.0, -30.0, 30.15), 1, 76.1, 120.0)],
}
Recipe = tuple[str, int]


def recipe(name: str, seed: int) -> tuple[Bar, list[Cutter]]:
    if name in INSIDE:
        return BEAM, INSIDE[name]
    if name in TUBES:
        return TUBE, TUBES[name]
    random = Random(seed)
    return FAMILIES[name](random, some_bar(random, "I U L B"))


def rows(recipes: list[Recipe], workers: int) -> list[tuple[str, ...]]:
    """Of each member its part and its messages, without its GlobalId."""
    made = Cuts()
    for name, seed in recipes:
        of = made.small.element(made.body(*recipe(name, seed)))
        if seed % 2:  # a weight that denies what the kernel says of a plain member
            made.small.properties(of, "Quantities", NetWeight=f"IFCMASSMEASURE({63.3})")
    found = read(made.small.data, "m.ifc", options=Options(kernel=True, workers=workers))
    lines = made.small.data.decode().splitlines()
    guids = [line.split("'")[1] for line in lines if "=IFCBEAM(" in line]
    out = []
    for guid in guids:
        parts = [repr(part).replace(guid, "?") for part in found.parts if part.guid == guid]
        said = [str(d).replace(guid, "?") for d in found.diagnostics if d.source.where == guid]
        out.append((*parts, *said))
    return out


@cache
def alone(one: Recipe) -> tuple[str, ...]:
    (row,) = rows([one], workers=1)
    assert row
    return row


RECIPES = st.tuples(
    st.sampled_from([*INSIDE, *INSIDE, *TUBES, "copes", "drilled"]), st.integers(0, 3)
)


@settings(max_examples=examples(12), deadline=None)
@given(st.lists(RECIPES, min_size=2, max_size=6), st.sampled_from((1, 2, 3)))
def test_each_member_is_the_same_alone_and_in_company(recipes: list[Recipe], workers: int) -> None:
    assert rows(recipes, workers) == [alone(one) for one in recipes]


@pytest.mark.parametrize("last", ["bore", "other bore", "fillet"])
def test_a_cut_that_no_level_shows_is_not_lost_behind_a_plain_member(last: str) -> None:
    row = rows([("plain", 0), ("far", 0), (last, 0)], workers=1)[-1]
    assert any("ifc-unexplained" in line or "ifc-root-fillet" in line for line in row)
