"""Colours of drawings: read, compared by hue, and mapped to what a machine does with them.

A colour is text "#rrggbb" in lower case. A drawing program that converts to CMYK and back turns
red into #ed3237 and black into #1f1a17, so a table that says "red" is matched by hue.
"""

import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from colorsys import rgb_to_hsv
from itertools import takewhile
from math import inf

from beamcam.machine.torch import OTHERS
from beamcam.model.colour_names import NAMES
from beamcam.model.part import Contour, Process

#: Hues further apart are two colours. The primaries are 60 degrees apart; converted CMYK inks lie
#: up to 18 degrees from theirs (cyan #00a0e3), and an ink between two primaries must match none.
MAX_HUE_DISTANCE_DEG = 20.0

#: Below this difference of the greatest and the least channel a colour is a grey: converted black
#: is #373435, a chroma of 0.01.
GREY_CHROMA = 0.12
#: From this difference on the hue says which colour it is; between both it is neither.
HUE_CHROMA = 0.30
#: The greatest channel of a black, the least of a white; between them lie the greys.
BLACK_VALUE = 0.30
WHITE_VALUE = 0.90

_HEX = re.compile(r"#([0-9a-f]{3}|[0-9a-f]{6})\Z", re.IGNORECASE)
_RGB = re.compile(r"rgba?\(([^()]*)\)\Z", re.IGNORECASE)


def parse_colour(text: str) -> str:
    """The colour of "#RGB", "#RRGGBB", "rgb(255, 0, 0)", "rgb(100%, 0%, 0%)" or a CSS name.

    Raises ValueError for anything else.
    """
    word = text.strip()
    if _HEX.match(word):
        digits = word[1:].lower()
        return "#" + (digits if len(digits) == 6 else "".join(d + d for d in digits))
    if word.lower() in NAMES:
        return NAMES[word.lower()]
    if found := _RGB.match(word):
        channels = [c for c in re.split(r"[\s,/]+", found[1].strip()) if c][:3]
        if len(channels) == 3:
            return _hex(tuple(_channel(c) for c in channels))
    raise ValueError(f"found {text!r}, expected #RRGGBB, rgb(r, g, b) or the name of a colour")


def _channel(text: str) -> float:
    share = float(text[:-1]) / 100 if text.endswith("%") else float(text) / 255
    return min(max(share, 0.0), 1.0)


def _hex(channels: tuple[float, ...]) -> str:
    return "#" + "".join(f"{round(c * 255):02x}" for c in channels)


def channels_of(colour: str) -> tuple[float, float, float]:
    """Red, green and blue of "#rrggbb", each in [0, 1]."""
    red, green, blue = (int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5))
    return red, green, blue


def chroma(colour: str) -> float:
    """Maximum minus minimum channel: 0 for a grey, 1 for a pure colour."""
    return max(channels_of(colour)) - min(channels_of(colour))


def hue_deg(colour: str) -> float:
    """Hue in degrees, [0, 360): red 0, green 120, blue 240; 0 for a grey."""
    return rgb_to_hsv(*channels_of(colour))[0] * 360.0


def hue_distance_deg(first: str, second: str) -> float:
    """Angle between two hues in degrees, [0, 180]; 0 for two blacks, greys or whites.

    inf where one has a hue and the other has none, for black against grey or white, and where a
    colour is too pale to say (a pink).
    """
    a, b = _shade(first), _shade(second)
    if a != b or a == "pale":
        return 0.0 if first == second else inf
    if a != "hue":
        return 0.0
    apart = abs(hue_deg(first) - hue_deg(second))
    return min(apart, 360.0 - apart)


def _shade(colour: str) -> str:
    """How a colour is compared: by "hue", "black", "grey" or "white", or "pale": not at all."""
    span, value = chroma(colour), max(channels_of(colour))
    if span >= HUE_CHROMA:
        return "hue"
    if span >= GREY_CHROMA:
        return "pale"
    return "black" if value <= BLACK_VALUE else "white" if value >= WHITE_VALUE else "grey"


def nearest_colour(colour: str, choices: Iterable[str]) -> str | None:
    """That of `choices` (names or "#rrggbb") which `colour` stands for, as it is written there.

    An equal colour wins; else the one nearest in hue, at most `MAX_HUE_DISTANCE_DEG` away. None
    if there is none, or if two that differ are equally near.
    """
    known = [(choice, parse_colour(choice)) for choice in choices]
    for choice, value in known:
        if value == colour:
            return choice
    ranked = sorted(
        (hue_distance_deg(colour, value), index) for index, (_, value) in enumerate(known)
    )
    near = [entry for entry in ranked if entry[0] <= MAX_HUE_DISTANCE_DEG]
    if not near:
        return None
    rivals = {known[index][1] for distance, index in near if distance <= near[0][0] + 1e-9}
    return known[near[0][1]][0] if len(rivals) == 1 else None


def colour_name(colour: str) -> str:
    """The CSS name that is exactly this colour, else the colour itself."""
    return next((name for name, value in NAMES.items() if value == colour), colour)


def process_of(contour: Contour, table: Mapping[str, Process]) -> Process | None:
    """The process that `table` assigns to `contour`; None if there is none."""
    key = key_of(contour, table)
    return None if key is None else table[key]


def key_of(contour: Contour, table: Collection[str]) -> str | None:
    """The key of `table` that stands for `contour`; None if there is none.

    The keys are layer names (any case) and colours ("red", "#0000FF"). The layer decides before
    the colour, an equal colour before one that is only near in hue. `OTHERS` stands for what none
    of the keys before it does, so that no key behind it counts.
    """
    named = list(takewhile(lambda key: key != OTHERS, table))
    found = _named(contour, named)
    return OTHERS if found is None and OTHERS in table else found


def _named(contour: Contour, table: Sequence[str]) -> str | None:
    if contour.layer is not None:
        wanted = contour.layer.casefold()
        for key in table:
            if key.casefold() == wanted:
                return key
    if contour.colour is None:
        return None
    return nearest_colour(contour.colour, [key for key in table if _is_colour(key)])


def _is_colour(key: str) -> bool:
    try:
        parse_colour(key)
    except ValueError:
        return False
    return True
