"""Families of members: slots, notched plates, tubes, and sections that are seldom drawn."""

from collections.abc import Sequence
from math import cos, pi, radians, sin
from random import Random

from tests.property.ifc_builder import Vec
from tests.property.ifc_cut_families import copes, drilled, mitred, some_bar, thinned, windows
from tests.property.ifc_cuts import Bar, Cuts, Cutter, Round, model_of, walls
from tests.unit.readers.ifc.models import Small


def slotted(random: Random) -> tuple[Bar, bytes]:
    """Slots of any angle through walls, some blind, some over an edge or an end."""
    bar = some_bar(random)
    made = Cuts()
    taken = []
    for _ in range(random.randint(1, 4)):
        normal, low, high, width = random.choice(list(walls(bar).values()))
        d, long = random.choice((14.0, 18.0, 22.0)), random.uniform(3, 60)
        x = random.choice((random.uniform(0, 60), random.uniform(100, bar.length - 100)))
        q = random.uniform(0, width)
        turn = random.choice((0.0, 0.0, pi / 2, random.uniform(0, pi)))
        deep = random.choice((3.0, 3.0, 3.0, -0.4 * (high - low)))  # beyond the wall, or within
        above = random.random() < 0.5
        depths = (low - deep, high + 3.0) if above else (low - 3.0, high + deep)
        taken.append(made.prism(bar, stadium(x, q, d, long, turn), normal, *depths))
    item = made.small.extruded(made.profile(bar), bar.length)
    made.small.element(made.small.minus(item, *taken))
    return bar, made.small.data


def stadium(x: float, q: float, d: float, long: float, turn: float) -> list[tuple[float, float]]:
    """A slot as exporters without arcs write it."""
    out = []
    for end, begin in ((1, -pi / 2), (-1, pi / 2)):
        for k in range(13):
            t = begin + pi * k / 12
            a, b = end * long / 2 + d / 2 * cos(t), d / 2 * sin(t)
            out.append((x + a * cos(turn) - b * sin(turn), q + a * sin(turn) + b * cos(turn)))
    return out


def plates(random: Random) -> tuple[Bar, bytes]:
    """Plates whose corners are notched, cut or rounded, with holes and hollows."""
    m = Small()
    long, wide, t = random.uniform(150, 900), random.uniform(80, 400), random.uniform(4, 40)
    turn = radians(random.choice((0.0, 0.0, random.uniform(0, 90))))

    def at(x: float, y: float) -> tuple[float, float]:
        return x * cos(turn) - y * sin(turn), x * sin(turn) + y * cos(turn)

    ring: list[tuple[float, float]] = []
    corners = ((0.0, 0.0, 1, 1), (long, 0.0, -1, 1), (long, wide, -1, -1), (0.0, wide, 1, -1))
    for i, (x, y, sx, sy) in enumerate(corners):
        dx, dy = random.uniform(5, 0.3 * long), random.uniform(5, 0.3 * wide)
        kind = random.choice(("sharp", "notch", "cut", "round"))
        ahead, after = (x + sx * dx, y), (x, y + sy * dy)
        if i % 2 == 0:
            ahead, after = after, ahead
        if kind == "sharp":
            ring.append((x, y))
        elif kind == "notch":
            ring += [ahead, (x + sx * dx, y + sy * dy), after]
        elif kind == "cut":
            ring += [ahead, after]
        else:
            r = min(dx, dy)
            cx, cy = x + sx * r, y + sy * r
            first = {0: pi, 1: -pi / 2, 2: 0.0, 3: pi / 2}[i]
            ring += [
                (cx + r * cos(first + pi / 2 * k / 40), cy + r * sin(first + pi / 2 * k / 40))
                for k in range(41)
            ]
    points = [m.step.point(*at(*p)) for p in ring]
    outer = m.add(f"IFCPOLYLINE(({','.join([*points, points[0]])}))")
    hollows = []
    for _ in range(random.randint(0, 3)):
        x, y = random.uniform(0.35, 0.65) * long, random.uniform(0.35, 0.65) * wide
        r = random.uniform(4, 0.03 * min(long, wide) + 4)
        spot = m.add(f"IFCAXIS2PLACEMENT2D({m.step.point(*at(x, y))},$)")
        if all(abs(x - u) + abs(y - v) > 3 * (r + s) for u, v, s, _ in hollows):
            hollows.append((x, y, r, m.add(f"IFCCIRCLE({spot},{m.step.length(r)})")))
    if hollows:
        inner = ",".join(h[3] for h in hollows)
        profile = m.add(f"IFCARBITRARYPROFILEDEFWITHVOIDS(.AREA.,$,{outer},({inner}))")
    else:
        profile = m.add(f"IFCARBITRARYCLOSEDPROFILEDEF(.AREA.,$,{outer})")
    body = m.extruded(profile, t)
    if random.random() < 0.5:
        o = (-5.0, *at(0.3 * long, 0.5 * wide))
        body = m.minus(body, m.hole(o, (1, 0, 0), random.choice((14.0, 18.0, 22.0)), t + 10))
    m.element(body, random.choice(("IFCPLATE", "IFCBEAM")))
    return Bar("B", long, (wide, t, 0.0, t, 0.0)), m.data


def special(random: Random) -> tuple[Bar, bytes]:
    """Asymmetric I, Z, channels with lips, gutters and corners: with mitres and holes."""
    m = Small()
    kind = random.choice(("asymmetric", "asymmetric", "z", "c", "gutter", "hexagon"))
    h, b, t = random.uniform(100, 400), random.uniform(60, 200), random.uniform(3, 15)
    if kind == "asymmetric":
        c, u, r = random.uniform(60, 200), random.uniform(5, 20), random.choice((0.0, 8.0))
        profile = m.add(
            f"IFCASYMMETRICISHAPEPROFILEDEF(.AREA.,$,{m.flat},{b},{h},{t},{u},{r},{c},{u + 2},{r},"
            "$,$,$,$)"
        )
    elif kind == "z":
        profile = m.add(f"IFCZSHAPEPROFILEDEF(.AREA.,$,{m.flat},{h},{b},{t},{t + 1},0.,$)")
    elif kind == "c":
        girth, r = random.uniform(0.12, 0.25) * h, random.choice((0.0, 3.0))
        profile = m.add(f"IFCCSHAPEPROFILEDEF(.AREA.,$,{m.flat},{h},{b},{t / 2},{girth},{r})")
    elif kind == "gutter":
        ring = [(0, 0), (b, 0), (b, h / 2), (b - t, h / 2), (b - t, t), (t, t), (t, h), (0, h)]
        profile = m.polygon(*ring)
    else:
        profile = m.polygon(*((b * cos(pi * k / 3), b * sin(pi * k / 3)) for k in range(6)))
    length = random.uniform(600, 2500)
    body = m.extruded(profile, length)
    if random.random() < 0.4:
        turn = radians(random.uniform(-40, 40))
        way = random.choice(((cos(turn), sin(turn), 0.0), (cos(turn), 0.0, sin(turn))))
        body = m.minus(body, m.half((length - 150.0, 0.0, 0.0), way))
    if random.random() < 0.3:
        o = (random.uniform(200, length - 400), -500.0, random.uniform(-0.3, 0.3) * h)
        body = m.minus(body, m.hole(o, (0, 1, 0), 18.0, 1000.0))
    m.element(body)
    return Bar("SO", length, (h, b, t, t, 0.0)), m.data


def kinked(random: Random) -> tuple[Bar, bytes]:
    """Bars of two pieces, curved ones and tapered ones: never a straight one in silence."""
    m = Small()
    profile = random.choice((m.ipe300(), m.box(20, 90), m.circle(60.0)))
    turn = radians(random.uniform(0.3, 60))
    x, y = cos(turn), sin(turn)
    kind = random.choice(("kinked", "curved", "shifted"))
    if kind == "curved":
        axis = m.add(
            f"IFCAXIS1PLACEMENT({m.step.point(0, random.uniform(800, 9000), 0)},"
            f"{m.step.direction(1, 0, 0)})"
        )
        at = m.step.axes((0, 0, 0), (1, 0, 0), (0, 1, 0))
        angle = m.step.num(random.uniform(3, 60))
        body = m.add(f"IFCREVOLVEDAREASOLID({profile},{at},{axis},{angle})")
    else:
        o: Vec = (990.0, 0.0, 0.0) if kind == "kinked" else (990.0, random.uniform(0.5, 30), 0.0)
        way = (x, y, 0.0) if kind == "kinked" else (1.0, 0.0, 0.0)
        far = m.step.axes(o, way, (-way[1], way[0], 0.0))
        pieces = m.extruded(profile, 1000.0), m.extruded(profile, random.uniform(300, 1500), far)
        body = m.add(f"IFCBOOLEANRESULT(.UNION.,{pieces[0]},{pieces[1]})")
    m.element(body)
    return Bar("I", 1000.0, (300.0, 150.0, 10.7, 7.1, 15.0)), m.data


def round_holes(random: Random) -> tuple[Bar, bytes]:
    """Tubes with holes through their axis, all that a drill can make."""
    bar = some_bar(random, "RO RO RU M")
    h, b = bar.sizes[:2]
    cutters: list[Cutter] = []
    for _ in range(random.randint(1, 6)):
        x, along = random.uniform(80, bar.length - 80), random.choice((1, 2))
        q = (b, h)[along - 1] / 2 if bar.code != "M" else random.uniform(25, (b, h)[along - 1] - 25)
        at = [x, q, q]
        at[along] = random.choice((-10.0, -10.0, (h, b)[along - 1] / 2))
        cutters.append(Round((at[0], at[1], at[2]), along, random.uniform(8, 0.3 * b), h + 30.0))
    return bar, model_of(bar, cutters)


def lipped(random: Random) -> tuple[Bar, bytes]:
    """Cold formed channels with lips, with cuts of every kind."""
    h, b, t = random.uniform(80, 300), random.uniform(40, 110), random.choice((1.5, 2.0, 3.0, 4.0))
    radius = random.choice((0.0, t, 2 * t))
    girth = random.uniform(t + radius + 3.0, 0.35 * h)
    bar = Bar("C", random.uniform(600, 2500), (h, b, t, t, radius), girth)
    return bar, model_of(bar, _some_cuts(random, bar))


def angles(random: Random) -> tuple[Bar, bytes]:
    """Angles of two thicknesses, with cuts of every kind."""
    h, b = random.uniform(60, 250), random.uniform(50, 200)
    flange, web = random.uniform(4, 0.2 * b), random.uniform(4, 0.2 * h)
    radius = random.choice((0.0, random.uniform(4, 14)))
    bar = Bar("L", random.uniform(600, 2500), (h, b, flange, web, radius))
    return bar, model_of(bar, _some_cuts(random, bar))


def _some_cuts(random: Random, bar: Bar) -> Sequence[Cutter]:
    family = random.choice((copes, mitred, windows, drilled, drilled, thinned, None))
    return family(random, bar)[1] if family is not None else ()
