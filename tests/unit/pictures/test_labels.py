"""Numbers beside what they name: none over another, and none far off."""

from math import hypot

from hypothesis import given
from hypothesis import strategies as st

from beamcam.pictures.scene import CAPITAL, LETTER, Labels

PLACES = st.lists(st.tuples(st.integers(0, 120), st.integers(0, 60)), min_size=1, max_size=25)
SIZE, RADIUS = 9.0, 2.0


@given(PLACES)
def test_no_label_lies_over_another_or_over_a_hole(places: list[tuple[int, int]]) -> None:
    labels = Labels()
    holes = [(x - RADIUS, y - RADIUS, x + RADIUS, y + RADIUS) for x, y in places]
    for hole in holes:
        labels.block(hole)
    boxes = []
    for number, at in enumerate(places, 1):
        found = labels.place(at, RADIUS, str(number), SIZE)
        if found is not None:
            wide, high = LETTER * SIZE * len(str(number)), CAPITAL * SIZE
            boxes.append((found[0], found[1] - high, found[0] + wide, found[1]))
            middle = found[0] + wide / 2, found[1] - high / 2
            assert hypot(middle[0] - at[0], middle[1] - at[1]) < 3 * (RADIUS + high + wide)
    taken = [*boxes, *holes]
    for k, a in enumerate(boxes):
        for b in taken[k + 1 :]:
            assert a[2] <= b[0] or b[2] <= a[0] or a[3] <= b[1] or b[3] <= a[1]


def test_alone_it_stands_to_the_upper_right() -> None:
    x, y = Labels().place((50.0, 50.0), RADIUS, "7", SIZE) or (0.0, 0.0)
    assert x > 50.0
    assert y < 50.0
