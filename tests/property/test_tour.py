"""The order of contours against the slow way: everything measured at each step."""

from math import dist, inf
from random import Random

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from beamcam.errors import Source
from beamcam.geometry.curves import Line
from beamcam.planning.contours.order import (
    MIN_GAIN,
    PASSES,
    WINDOW,
    nearest_first,
    order,
    turn_stretches,
)
from beamcam.planning.contours.outline import Shape
from tests.conftest import examples

HERE = (0.0, 0.0)


@st.composite
def tours(draw, most=40):
    """Starts, ends and parents of contours; places often coincide, and a few lie far off."""
    place = st.one_of(
        st.tuples(st.integers(0, 12), st.integers(0, 12)),
        st.tuples(st.integers(-900, 900), st.integers(0, 12)),
    )
    count = draw(st.integers(1, most))
    starts = [
        (float(x), float(y)) for x, y in draw(st.lists(place, min_size=count, max_size=count))
    ]
    ends = [
        start if draw(st.booleans()) else (start[0] + draw(st.integers(1, 5)), start[1])
        for start in starts
    ]
    parents = [draw(st.sampled_from([-1, -1, *range(k)])) for k in range(count)]
    return starts, ends, parents


def greedy(starts, ends, parents, here):
    """The nearest of all free contours each time."""
    waiting = [sum(p == k for p in parents) for k in range(len(starts))]
    free = [k for k in range(len(starts)) if not waiting[k]]
    tour = []
    while free:
        key = {
            (side, n): (
                (places[k][0] - here[0]) ** 2 + (places[k][1] - here[1]) ** 2 if k >= 0 else inf
            )
            for side, places in enumerate((starts, ends))
            for n, k in enumerate(free)
        }
        side, n = min(key, key=lambda choice: (key[choice], choice))
        k = free[n]
        if key[side, n] == inf:
            break
        free[n] = -1
        tour.append((k, bool(side)))
        here = starts[k] if side else ends[k]
        if parents[k] >= 0:
            waiting[parents[k]] -= 1
            if not waiting[parents[k]]:
                free.append(parents[k])
    return tour


@settings(max_examples=examples(60), deadline=None)
@given(tours())
def test_the_nearest_is_the_nearest_of_all(found):
    starts, ends, parents = found
    stage = range(len(starts))
    assert nearest_first(stage, starts, ends, parents, HERE) == greedy(starts, ends, parents, HERE)


def turned(tour, starts, ends, parents, here):
    """Every stretch from every place, in the order of the places."""
    tour = list(tour)
    count = len(tour)

    def into(k):
        node, back = tour[k]
        return ends[node] if back else starts[node]

    def out(k):
        node, back = tour[k]
        return starts[node] if back else ends[node]

    for _ in range(PASSES):
        improved = False
        for i in range(count - 1):
            before = here if i == 0 else out(i - 1)
            best, best_gain = -1, MIN_GAIN
            for j in range(i + 1, min(count, i + WINDOW)):
                if any(parents[tour[k][0]] == tour[j][0] for k in range(i, j)):
                    break
                gain = dist(into(i), before) - dist(out(j), before)
                if j + 1 < count:
                    gain += dist(into(j + 1), out(j)) - dist(into(j + 1), into(i))
                if gain > best_gain:
                    best, best_gain = j, gain
            if best > 0:
                tour[i : best + 1] = [(k, not back) for k, back in tour[i : best + 1][::-1]]
                improved = True
        if not improved:
            break
    return tour


def length(tour, starts, ends, here):
    total = 0.0
    for k, back in tour:
        total += dist(here, ends[k] if back else starts[k])
        here = starts[k] if back else ends[k]
    return total


@settings(max_examples=examples(25), deadline=None)
@given(st.integers(0, 10**6), st.sampled_from((5, 30, 75)), st.booleans())
def test_stretches_are_turned_as_the_slow_way_turns_them(seed, count, nested):
    random = Random(seed)
    starts = [(random.uniform(0, 99), random.uniform(0, 99)) for _ in range(count)]
    ends = [s if random.random() < 0.5 else (s[0] + random.random(), s[1]) for s in starts]
    share = 0.2 if nested else 0.0
    parents = [random.randrange(k) if k and random.random() < share else -1 for k in range(count)]
    first = nearest_first(range(count), starts, ends, parents, HERE)
    quick = turn_stretches(first, np.array(starts), np.array(ends), np.array(parents), HERE)
    assert quick == turned(first, starts, ends, parents, HERE)
    assert length(quick, starts, ends, HERE) <= length(first, starts, ends, HERE)
    places = {k: n for n, (k, _) in enumerate(quick)}
    assert sorted(places) == list(range(count))
    assert all(p < 0 or places[k] < places[p] for k, p in enumerate(parents))


@settings(max_examples=examples(40), deadline=None)
@given(tours(20), st.data())
def test_marks_come_before_cuts(found, data):
    starts, ends, _ = found
    shapes = [
        Shape(
            data.draw(st.sampled_from(("cut", "mark"))),
            (Line(a, b),) if a != b else (Line(a, (a[0] + 1, a[1])), Line((a[0] + 1, a[1]), a)),
            a == b,
            (k,),
            Source("random"),
        )
        for k, (a, b) in enumerate(zip(starts, ends, strict=True))
    ]
    tour = order(shapes)
    assert sorted(k for k, _ in tour) == list(range(len(shapes)))
    processes = [shapes[k].process for k, _ in tour]
    assert processes == sorted(processes, reverse=True)
