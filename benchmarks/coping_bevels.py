"""Ways to make passes along bevels wrong whose torch turns about the bar, or along a curve."""

import random
import re
from collections.abc import Callable
from math import cos, hypot, radians, tan

from msgspec.structs import replace

from beamcam.model.plan import CopeCut, CopePlan
from benchmarks.coping_texts import Lines, OfText

OfPlan = Callable[[CopePlan, random.Random], CopePlan | None]
Turn = tuple[float, float]  #: A off its face and B


#: A torch that leans along its edge makes a wedge that is t tan(b) (1 - cos along) off; so many mm,
#: and degrees off its angle, are within what a sound program may be off.
SAME_WEDGE, SAME_DEG = 0.1, 0.5


def turned(cut: CopeCut, change: Callable[[Turn], Turn]) -> CopeCut:
    """A cut whose torch is turned otherwise, on all of its way."""
    off, b_deg = change((cut.a_off_deg, cut.b_deg))
    return replace(cut, a_off_deg=off, b_deg=b_deg, turns=tuple(map(change, cut.turns)))


def changed(plan: CopePlan, chance: random.Random, change: Callable[[CopeCut], CopeCut | None],
            fits: Callable[[CopeCut], bool] = lambda cut: True) -> CopePlan | None:  # fmt: skip
    """The plan with one of its cuts changed."""
    which = [k for k, cut in enumerate(plan.operations) if fits(cut)]
    if not which:
        return None
    k = chance.choice(which)
    other = change(plan.operations[k])
    if other is None:
        return None
    return replace(plan, operations=(*plan.operations[:k], other, *plan.operations[k + 1 :]))


def _one(
    change: Callable[[CopeCut, random.Random], CopeCut | None],
    fits: Callable[[CopeCut], bool] = lambda cut: True,
) -> OfPlan:
    """A plan with one of its bevels changed."""
    return lambda plan, chance: changed(
        plan, chance, lambda cut: change(cut, chance), lambda cut: cut.bevel and fits(cut)
    )


def _a_off_by(cut: CopeCut, by: float) -> CopeCut:
    return turned(cut, lambda t: (t[0] + by, t[1]))


def turns_about_the_bar(cut: CopeCut) -> bool:
    """Whether A leaves its face by enough to matter."""
    return max(abs(off) for off, _ in (*cut.turns, (cut.a_off_deg, 0.0))) > 3.0


def is_round(cut: CopeCut) -> bool:
    return bool(cut.turns)


def _standing(cut: CopeCut, chance: random.Random) -> CopeCut | None:
    """A torch that does not turn along a curve, where that makes another wedge."""
    off, b_deg = only = chance.choice(cut.turns)
    along = max(abs(a - off) for a, _ in cut.turns)
    wedge = cut.row.up_to * tan(radians(b_deg)) * (1.0 - cos(radians(along)))
    if wedge < SAME_WEDGE and max(abs(b - b_deg) for _, b in cut.turns) < SAME_DEG:
        return None
    return replace(cut, turns=(only,) * len(cut.turns))


def _chord(cut: CopeCut, chance: random.Random) -> CopeCut | None:
    """A curve by one straight stretch from its start to its end, where that leaves it."""
    (xa, ya), (xb, yb), (xm, ym) = cut.path[2], cut.path[-2], cut.path[len(cut.path) // 2]
    if abs((xm - (xa + xb) / 2) + (ym - (ya + yb) / 2)) < 1.0:
        return None
    return replace(
        cut, path=(*cut.path[:3], *cut.path[-2:]), turns=(*cut.turns[:3], *cut.turns[-2:])
    )


def _late(cut: CopeCut, chance: random.Random) -> CopeCut | None:
    """A torch that turns too late, by so much that it matters."""
    (off, b_deg), turns = cut.turns[0], cut.turns
    late = next((k for k, (a, b) in enumerate(turns) if hypot(a - off, b - b_deg) > 12.0), None)
    return None if late is None else replace(cut, turns=(*turns[:1] * late, *turns[:-late]))


def _land(cut: CopeCut, chance: random.Random) -> CopeCut | None:
    """A pass whose land is another one by 1 mm, across the bar."""
    (xa, ya), (xb, yb) = cut.path[-2:]
    long = ((xb - xa) ** 2 + (yb - ya) ** 2) ** 0.5
    off = chance.choice((-1.0, 1.0)) * max(0.35, tan(radians(abs(cut.a_off_deg or cut.b_deg))))
    dx, dy = -(yb - ya) / long * off, (xb - xa) / long * off
    return replace(cut, path=(cut.path[0], *((x + dx, y + dy) for x, y in cut.path[1:])))


def _round_land(cut: CopeCut, chance: random.Random) -> CopeCut:
    """A pass along a curve that lies 0.4 mm farther in or out, all of it."""
    off, path = chance.choice((-0.4, 0.4)), [cut.path[0]]
    for k in range(1, len(cut.path)):
        (xa, ya), (xb, yb) = cut.path[max(k - 1, 1)], cut.path[min(k + 1, len(cut.path) - 1)]
        long = ((xb - xa) ** 2 + (yb - ya) ** 2) ** 0.5
        x, y = cut.path[k]
        path.append((x - (yb - ya) / long * off, y + (xb - xa) / long * off))
    return replace(cut, path=tuple(path))


def _other_side(plan: CopePlan, chance: random.Random) -> CopePlan | None:
    """A pass along the bar on the other edge of its face."""
    return _one(lambda cut, _: replace(
        cut, path=tuple((x, plan.profile.face_width(cut.face) - y) for x, y in cut.path)
    ), lambda cut: cut.kind == "notch")(plan, chance)  # fmt: skip


def _short(cut: CopeCut, chance: random.Random) -> CopeCut:
    """A pass that ends 9 mm before its run-out does."""
    (xa, ya), (xb, yb) = cut.path[-2:]
    long = ((xb - xa) ** 2 + (yb - ya) ** 2) ** 0.5
    share = max(0.0, (long - 9.0) / long)
    last = xa + share * (xb - xa), ya + share * (yb - ya)
    return replace(cut, path=(*cut.path[:-1], last))


def whole_of(plan: CopePlan) -> list[tuple[CopeCut, list[CopeCut]]]:
    """The passes that alone make their edges, each with the square cuts that end in their kerfs."""
    from shapely import LineString
    from shapely import Point as Place

    found = []
    for cut in plan.operations:
        way, reach = LineString(cut.path[1:]), cut.row.kerf / 2
        along = [one for one in plan.operations if (one.face, one.kind) == (cut.face, cut.kind)
                 and not one.bevel]  # fmt: skip
        own = [one for one in along if way.distance(Place(one.path[-1])) <= reach]
        if cut.lower and (own or cut.kind == "inner"):
            found.append((cut, own))
    return found


def _whole_left_out(plan: CopePlan, chance: random.Random) -> CopePlan | None:
    """A pass that alone makes its edge, left out."""
    which = [cut for cut, _ in whole_of(plan)]
    if not which:
        return None
    gone = chance.choice(which)
    return replace(plan, operations=tuple(cut for cut in plan.operations if cut is not gone))


def _short_beside(plan: CopePlan, chance: random.Random) -> CopePlan | None:
    """A square cut that ends 4 mm before the kerf of the pass that makes the next edge."""
    which = [one for _, own in whole_of(plan) for one in own]
    if not which:
        return None
    cut = chance.choice(which)
    (xa, ya), (xb, yb) = cut.path[-2:]
    gone = min(1.0, (4.0 + cut.row.kerf) / hypot(xb - xa, yb - ya))
    last = xb - gone * (xb - xa), yb - gone * (yb - ya)
    shorter = replace(cut, path=(*cut.path[:-1], last))
    before = hypot(cut.path[-3][0] - xa, cut.path[-3][1] - ya) if len(cut.path) > 3 else 0.0
    if hypot(xb - xa, yb - ya) < cut.row.kerf < before:  # the last stretch is all in that kerf
        (xc, yc) = cut.path[-3]
        share = 1.0 - 4.0 / before
        shorter = replace(
            cut, path=(*cut.path[:-2], (xc + share * (xa - xc), yc + share * (ya - yc)))
        )
    return replace(plan, operations=tuple(shorter if c is cut else c for c in plan.operations))


BEVEL_PLANS: dict[str, OfPlan] = {
    "bevel through the wall left out": _whole_left_out,
    "square cut short of a bevel": _short_beside,
    "A the other way": _one(
        lambda cut, c: turned(cut, lambda t: (-t[0], t[1])), turns_about_the_bar
    ),
    "A dropped": _one(lambda cut, c: turned(cut, lambda t: (0.0, t[1])), turns_about_the_bar),
    "A of another angle": _one(lambda cut, c: _a_off_by(cut, c.choice((-3.0, 3.0)))),
    "A and B the other way": _one(lambda cut, c: turned(cut, lambda t: (-t[0], -t[1]))),
    "a torch that does not turn": _one(_standing, is_round),
    "a curve by its chord": _one(_chord, is_round),
    "turned too late": _one(_late, is_round),
    "land of a bevel": _one(_land, lambda cut: not cut.turns),
    "land of a round bevel": _one(_round_land, is_round),
    "bevel on the other edge": _other_side,
    "bevel too short": _one(_short),
}  # fmt: skip


def _of_block(change: Callable[[re.Match[str], random.Random], str | None]) -> OfText:
    """A block of inverse time of a coper, on which the torch turns, changed."""
    pattern = r"(G93 G1 X\S+ Y\S+) Z(\S+) A(\S+) B(\S+) F(\S+)"

    def of_text(lines: Lines, chance: random.Random) -> Lines | None:
        which = [k for k, line in enumerate(lines) if re.fullmatch(pattern, line)]
        if len(which) < 9:
            return None
        k = chance.choice(which[3:-3])
        match = re.fullmatch(pattern, lines[k])
        other = change(match, chance) if match is not None else None
        return [*lines[:k], *([] if other is None else [other]), *lines[k + 1 :]]

    return of_text


BEVEL_TEXTS: dict[str, OfText] = {
    "A of a block": _of_block(
        lambda m, c: f"{m[1]} Z{m[2]} A{float(m[3]) + c.choice((-4, 4)):g} B{m[4]} F{m[5]}"
    ),
    "B of a block": _of_block(
        lambda m, c: f"{m[1]} Z{m[2]} A{m[3]} B{float(m[4]) + c.choice((-4, 4)):g} F{m[5]}"
    ),
    "time of a block": _of_block(
        lambda m, c: f"{m[1]} Z{m[2]} A{m[3]} B{m[4]} F{float(m[5]) * c.choice((0.7, 1.4)):g}"
    ),
    "time of a block missing": _of_block(lambda m, c: f"{m[1]} Z{m[2]} A{m[3]} B{m[4]}"),
    "height of a block": _of_block(
        lambda m, c: f"{m[1]} Z{float(m[2]) + c.choice((-1, 1)):g} A{m[3]} B{m[4]} F{m[5]}"
    ),
    "turned by the feed": _of_block(lambda m, c: f"G94 G1{m[0].removeprefix('G93 G1')}"),
}  # fmt: skip
