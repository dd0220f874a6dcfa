"""Members with cuts of every kind and proportion."""

from math import cos, radians, sin
from random import Random

from tests.property.ifc_cuts import SIZES, Bar, Box, Cutter, Half, Round, walls


def some_bar(random: Random, codes: str = "I I U L T M B") -> Bar:
    code = random.choice(codes.split())
    factor = random.choice((1.0, 1.0, 0.6, 1.7))
    sizes = tuple(round(v * factor, 2) for v in SIZES[code])
    return Bar(code, round(random.uniform(600, 2500), 1), sizes)  # type: ignore[arg-type]


def cope(random: Random, bar: Bar, tilt: float = 0.0) -> Box:
    """A block at an end, from above or below, over the width or over a side of it."""
    h, b = bar.sizes[:2]
    long = random.uniform(5, 0.3 * bar.length)
    deep = random.choice((random.uniform(2, 0.15 * h), random.uniform(0.05 * h, 0.6 * h)))
    x = (-20.0, long) if random.random() < 0.5 else (bar.length - long, bar.length + 20.0)
    y = (-20.0, deep) if random.random() < 0.5 else (h - deep, h + 20.0)
    z = (-20.0, b + 20.0)
    if random.random() < 0.25 and bar.code in ("I", "M"):
        tw = bar.sizes[3]
        z = (-20.0, (b - tw) / 2) if random.random() < 0.5 else ((b + tw) / 2, b + 20.0)
    tilts = (random.uniform(-tilt, tilt), random.uniform(-tilt, tilt))
    return Box((x[0], y[0], z[0]), (x[1], y[1], z[1]), tilts)


def copes(random: Random, bar: Bar | None = None) -> tuple[Bar, list[Cutter]]:
    bar = bar or some_bar(random)
    return bar, [cope(random, bar) for _ in range(random.randint(1, 4))]


def tilted(random: Random, bar: Bar | None = None) -> tuple[Bar, list[Cutter]]:
    bar = bar or some_bar(random)
    tilt = 10 ** random.uniform(-7, -3)
    return bar, [cope(random, bar, tilt) for _ in range(random.randint(1, 2))]


def mitred(random: Random, bar: Bar | None = None) -> tuple[Bar, list[Cutter]]:
    """Mitres, some in two halves, some with a cope beside them."""
    bar = bar or some_bar(random)
    h, b = bar.sizes[:2]
    out: list[Cutter] = []
    for _ in range(random.randint(1, 3)):
        turn = radians(random.choice((0.0, 15.0, 30.0, 45.0, random.uniform(-50, 50))))
        lean = radians(random.choice((0.0, 0.0, random.uniform(-40, 40))))
        end = random.random() < 0.6
        x = bar.length - random.uniform(5, 120) if end else random.uniform(5, 120)
        side = 1.0 if end else -1.0
        normal = (side * cos(turn) * cos(lean), sin(turn) * cos(lean), sin(lean))
        out.append(Half((x, h / 2, b / 2), normal))
    if random.random() < 0.5:
        out.append(cope(random, bar))
    return bar, out


def windows(random: Random, bar: Bar | None = None) -> tuple[Bar, list[Cutter]]:
    """Openings of any size in any wall, some through both of a tube's, some over an edge."""
    bar = bar or some_bar(random)
    out: list[Cutter] = []
    for _ in range(random.randint(1, 3)):
        normal, low, high, width = random.choice(list(walls(bar).values()))
        x, q = random.uniform(50, bar.length - 50), random.uniform(0, width)
        dx, dq = random.uniform(5, 120), random.uniform(5, 0.4 * width)
        a, c = [x - dx, q - dq, q - dq], [x + dx, q + dq, q + dq]
        a[normal], c[normal] = low - 3, high + 3
        out.append(Box((a[0], a[1], a[2]), (c[0], c[1], c[2])))
    return bar, out


def drilled(random: Random, bar: Bar | None = None) -> tuple[Bar, list[Cutter]]:
    """Holes anywhere: near edges, over ends, into one another, in fillets, blind, askew."""
    bar = bar or some_bar(random, "I U L T M B RO RU")
    h, _ = bar.sizes[:2]
    out: list[Cutter] = []
    for _ in range(random.randint(1, 5)):
        if bar.code in ("RO", "RU"):
            q = random.choice((h / 2, h / 2, h / 2 + random.uniform(-0.3, 0.3) * h))
            x = random.choice((random.uniform(0, 60), random.uniform(100, bar.length - 100)))
            along = random.choice((1, 2))
            at = [x, q, q]
            at[along] = random.choice((-10.0, h / 2))
            d = random.uniform(6, 0.5 * h)
            out.append(Round((at[0], at[1], at[2]), along, d, h + 20.0))
            continue
        normal, low, high, width = random.choice(list(walls(bar).values()))
        at = [random.choice((random.uniform(0, 40), random.uniform(40, bar.length - 40))), 0.0, 0.0]
        at[3 - normal] = random.uniform(0, width)
        deep = random.choice((high - low + 6, high - low + 6, (high - low) * 0.6 + 3))
        at[normal] = low - 3 if random.random() < 0.5 else high + 3 - deep
        lean = random.choice((0.0, 0.0, 0.0, 0.0, 0.1))
        d = random.choice((14.0, 18.0, 22.0, 40.0))
        out.append(Round((at[0], at[1], at[2]), normal, d, deep, lean))
    return bar, out


def tubes(random: Random) -> tuple[Bar, list[Cutter]]:
    """Slots, saddles, windows and flats of round and square tubes."""
    bar = some_bar(random, "RO RO RU M")
    h, b, t = bar.sizes[0], bar.sizes[1], bar.sizes[3]
    kind = random.choice(("slot", "saddle", "window", "flat", "mitre", "cross"))
    long = random.uniform(20, 200)
    wide = random.uniform(4, 0.5 * b)
    end = random.random() < 0.5
    x = (bar.length - long, bar.length + 20.0) if end else (-20.0, long)
    out: list[Cutter] = []
    if kind in ("slot", "cross"):
        out.append(Box((x[0], -20.0, b / 2 - wide / 2), (x[1], h + 20.0, b / 2 + wide / 2)))
    if kind == "cross":
        out.append(Box((x[0], h / 2 - wide / 2, -20.0), (x[1], h / 2 + wide / 2, b + 20.0)))
    if kind == "saddle":
        at = bar.length if end else 0.0
        out.append(Round((at, -50.0, b / 2), 1, random.uniform(0.6, 2) * b, h + 100.0))
    if kind == "window":
        at = random.uniform(150, bar.length - 150)
        out.append(Box((at - long / 2, -20.0, b / 2 - wide), (at + long / 2, t * 2, b / 2 + wide)))
    if kind == "flat":
        out.append(Box((x[0], h - random.uniform(1, 0.4 * h), -20.0), (x[1], h + 20, b + 20.0)))
    if kind == "mitre" or random.random() < 0.3:
        turn = radians(random.uniform(-50, 50))
        out.append(Half((40.0, h / 2, b / 2), (-cos(turn), sin(turn), 0.0)))
    return bar, out


def bevelled(random: Random) -> tuple[Bar, list[Cutter]]:
    """Flat bars whose ends and edges are prepared for welding, from one side or both."""
    bar = some_bar(random, "B")
    h, t = bar.sizes[:2]
    out: list[Cutter] = []
    for _ in range(random.randint(1, 3)):
        turn = radians(random.choice((30.0, 37.5, 45.0, 60.0)))
        up = random.choice((-1.0, 1.0))
        land = random.uniform(0, 0.6) * t
        z = t - land if up > 0 else land
        if random.random() < 0.6:
            end = random.random() < 0.5
            at = (bar.length if end else 0.0, h / 2, z)
            normal = (cos(turn) * (1 if end else -1), 0.0, up * sin(turn))
        else:
            at, normal = (bar.length / 2, h, z), (0.0, cos(turn), up * sin(turn))
        out.append(Half(at, normal))
    return bar, out


def thinned(random: Random, bar: Bar | None = None) -> tuple[Bar, list[Cutter]]:
    """Planes and blocks along the member: flanges thinned, tapered, taken off."""
    bar = bar or some_bar(random, "I U L T M B")
    h, b, tf = bar.sizes[:3]
    if random.random() < 0.5:
        tilt = random.choice((0.0, 0.0, random.uniform(-0.02, 0.02)))
        return bar, [Half((bar.length / 2, h - random.uniform(1, 40), 0.0), (tilt, 1.0, 0.0))]
    x = sorted(random.uniform(-50, bar.length + 50) for _ in range(2))
    deep = random.uniform(0.3, 3) * (tf or 5.0)
    return bar, [Box((x[0], h - deep, -20.0), (x[1], h + 20.0, random.choice((b / 2, b + 20.0))))]


FAMILIES = {
    "copes": copes, "tilted": tilted, "mitred": mitred, "windows": windows, "drilled": drilled,
    "tubes": tubes, "bevelled": bevelled, "thinned": thinned,
}  # fmt: skip
