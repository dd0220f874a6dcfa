"""Numbers formatted in bulk: lines of a program from arrays.

    "G1 X{x} Y{y}", x and y    ->    G1 X123.456 Y-78.9

Each line is a record of fixed width, filled from tables of all groups of four digits. What a number
does not need of its field is a zero byte, and all of those are taken out at the end.
"""

from collections.abc import Mapping
from string import Formatter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from beamcam.caches import cached
from beamcam.emitters.gcode import number
from beamcam.geometry.array_types import Counts, Floats

Groups = NDArray[np.void]

GROUP = 10_000  #: of four digits
MOST_DECIMALS = 4  #: more are formatted one by one, and so are wholes of more than two groups
#: Beyond this share of a step beside the middle of two the nearest one is sure.
DOUBT = 1e-6

_PLACES = np.arange(GROUP)[:, None] // (1000, 100, 10, 1)
_TEXTS = (_PLACES % 10 + ord("0")).astype(np.uint8)
#: Without zeros before the first digit: none at all for 0, or, in the last group, one.
_SHOWN = np.where(_PLACES > 0, _TEXTS, 0).astype(np.uint8)
DIGITS, _HEAD = (texts.view("V4").reshape(-1) for texts in (_TEXTS, _SHOWN))
_LAST: Groups = np.concatenate((np.frombuffer(b"\0\0\0" + b"0", dtype="V4"), _HEAD[1:]))
_SIGNS: Groups = np.frombuffer(b"\0-", dtype="V1")


def lines(template: str, columns: Mapping[str, Floats], decimals: int) -> str:
    """A line for each row of the columns, with a newline at its end.

    Numbers have at most `decimals` places, as `emitters.numbers.number` writes them. `template` has
    a name in braces for each column that it shows; it holds no zero byte.
    """
    parts: list[tuple[str, bytes | Groups]] = []
    for text, name, _, _ in Formatter().parse(template + "\n"):
        if text:
            parts.append((f"V{len(text.encode())}", text.encode()))
        if name is not None:
            parts += [(f.dtype.str, f) for f in _fields(columns[name], decimals)]
    count = len(next(iter(columns.values())))
    record: Any = [(f"f{k}", kind) for k, (kind, _) in enumerate(parts)]
    rows = np.empty(count, dtype=record)
    for k, (kind, part) in enumerate(parts):
        rows[f"f{k}"] = np.frombuffer(part, dtype=kind)[0] if isinstance(part, bytes) else part
    return rows.tobytes().translate(None, b"\0").decode()


def _fields(values: Floats, decimals: int) -> list[Groups]:
    """Numbers as columns of bytes that are put side by side."""
    steps = _steps(values, decimals) if decimals <= MOST_DECIMALS else None
    if steps is None:
        texts = [number(value, decimals).encode() for value in values.tolist()]
        longest = max(map(len, texts), default=1)
        return [np.array(texts, dtype=f"S{longest}").view(f"V{longest}")]
    size = np.abs(steps)
    whole = size // 10**decimals
    fields = [_SIGNS.take(steps < 0)]
    high = whole // GROUP
    if high.any():
        low = whole - high * GROUP
        last = np.where(high > 0, DIGITS.take(low), _LAST.take(low))
        fields += [_HEAD.take(high), last]
    else:
        fields.append(_LAST.take(whole))
    if decimals:
        fields.append(_places(decimals).take(size - whole * 10**decimals))
    return fields


def _steps(values: Floats, decimals: int) -> Counts | None:
    """Numbers in steps of their last place, rounded as Python does; None if one is too large."""
    scaled = values * 10.0**decimals
    largest = float(np.abs(scaled).max(initial=0.0))
    if not largest < GROUP * GROUP * 10**decimals - 1:
        return None
    steps: Counts = np.rint(scaled).astype(np.int64)
    middle = np.abs(scaled - np.floor(scaled) - 0.5) < DOUBT
    for k in np.flatnonzero(middle).tolist():
        steps[k] = int(f"{values[k]:.{decimals}f}".replace(".", ""))
    return steps


@cached("numbers.places")
def _places(decimals: int) -> Groups:
    """The point and the places behind it, without zeros at the end; nothing for 0."""
    texts = [f".{k:0{decimals}d}".rstrip("0") for k in range(10**decimals)]
    texts[0] = ""
    width = decimals + 1
    return np.frombuffer(b"".join(t.encode().ljust(width, b"\0") for t in texts), dtype=f"V{width}")
