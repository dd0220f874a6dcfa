"""The attributes `transform` and `preserveAspectRatio` as affine maps of the plane."""

import re
from collections.abc import Callable
from math import radians, tan
from typing import Literal, NamedTuple

from beamcam.geometry.plane import IDENTITY, MAX_COORDINATE, Matrix, unit_vector

_ASPECT = re.compile(
    r"(?:defer\s+)?(?:(?P<none>none)|x(?P<x>Min|Mid|Max)Y(?P<y>Min|Mid|Max))"
    r"(?:\s+(?P<how>meet|slice))?"
)
_SHARES = {"Min": 0.0, "Mid": 0.5, "Max": 1.0}
_CALL = re.compile(r"[\s,]*(\w+)\s*\(([^()]*)\)\s*")


def product(first: Matrix, second: Matrix) -> Matrix:
    """The map that does `second`, then `first`."""
    (a, b, c), (d, e, f) = first
    (g, h, i), (j, k, m) = second
    return (
        (a * g + b * j, a * h + b * k, a * i + b * m + c),
        (d * g + e * j, d * h + e * k, d * i + e * m + f),
    )


def shift(x: float, y: float) -> Matrix:
    return (1.0, 0.0, x), (0.0, 1.0, y)


def scale(x: float, y: float) -> Matrix:
    return (x, 0.0, 0.0), (0.0, y, 0.0)


def _matrix(a: float, b: float, c: float, d: float, e: float, f: float) -> Matrix:
    # SVG lists the columns.
    return (a, c, e), (b, d, f)


def _rotate(angle_deg: float, x: float = 0.0, y: float = 0.0) -> Matrix:
    c, s = unit_vector(angle_deg)
    turn: Matrix = ((c, -s, 0.0), (s, c, 0.0))
    return product(product(shift(x, y), turn), shift(-x, -y))


#: Name to map and the counts of numbers that it takes. Source: SVG 1.1, section 7.6.
_MAPS: dict[str, tuple[Callable[..., Matrix], tuple[int, ...]]] = {
    "matrix": (_matrix, (6,)),
    "translate": (lambda x, y=0.0: shift(x, y), (1, 2)),
    "scale": (lambda x, y=None: scale(x, x if y is None else y), (1, 2)),
    "rotate": (_rotate, (1, 3)),
    "skewX": (lambda a: ((1.0, tan(radians(a)), 0.0), (0.0, 1.0, 0.0)), (1,)),
    "skewY": (lambda a: ((1.0, 0.0, 0.0), (tan(radians(a)), 1.0, 0.0)), (1,)),
}


def parse_transform(text: str) -> Matrix:
    """The map of "translate(1 2) rotate(90)", the last one done first.

    Raises ValueError with what was expected.
    """
    result, position = IDENTITY, 0
    text = text.strip()
    while position < len(text):
        call = _CALL.match(text, position)
        if call is None or call[1] not in _MAPS:
            raise ValueError(f"one of {', '.join(_MAPS)} with numbers in brackets")
        build, counts = _MAPS[call[1]]
        numbers = [float(n) for n in re.split(r"[\s,]+", call[2].strip()) if n]
        if len(numbers) not in counts:
            raise ValueError(f"{' or '.join(map(str, counts))} numbers in {call[1]}()")
        if not all(-MAX_COORDINATE <= number <= MAX_COORDINATE for number in numbers):
            raise ValueError(f"numbers of at most {MAX_COORDINATE:g}")
        result = product(result, build(*numbers))
        position = call.end()
    return result


class Fit(NamedTuple):
    """How a viewBox lies in its page. Source: SVG 1.1, section 7.8, preserveAspectRatio."""

    how: Literal["meet", "slice", "none"] = "meet"  #: seen whole, page filled, or stretched
    share_x: float = 0.5  #: of the free space that lies left of the drawing
    share_y: float = 0.5  #: above it
    said: bool = False  #: whether the file says it

    def scales(self, across: float, down: float) -> tuple[float, float]:
        """The scales of x and y, of those by width and by height."""
        if self.how == "none":
            return across, down
        one = max(across, down) if self.how == "slice" else min(across, down)
        return one, one


def fit_of(text: str | None) -> Fit:
    """What preserveAspectRatio says; xMidYMid meet where it says nothing that is known."""
    found = _ASPECT.fullmatch((text or "").strip())
    if found is None:
        return Fit()
    if found["none"]:
        return Fit("none", said=True)
    how: Literal["meet", "slice"] = "slice" if found["how"] == "slice" else "meet"
    return Fit(how, _SHARES[found["x"]], _SHARES[found["y"]], True)
