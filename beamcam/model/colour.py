"""Colours of drawings: read, compared by hue, and mapped to what a machine does with them.

A colour is text "#rrggbb" in lower case. A drawing program that converts to CMYK and back turns
red into #ed3237 and black into #1f1a17, so a table that says "red" is matched by hue.
"""

import re
from collections.abc import Collection, Iterable, Mapping
from colorsys import hls_to_rgb, rgb_to_hsv
from contextlib import suppress
from itertools import takewhile
from math import inf, pi

from beamcam.caches import cached
from beamcam.machine.torch import OTHERS
from beamcam.model.part import Contour, Dashed, Process

# The colour names of CSS: 148 names, as "#rrggbb".
#
# Source: CSS Color Module Level 4, section 6.1 "Named Colors".


_TABLE = """
aliceblue f0f8ff  antiquewhite faebd7  aqua 00ffff  aquamarine 7fffd4  azure f0ffff
beige f5f5dc  bisque ffe4c4  black 000000  blanchedalmond ffebcd  blue 0000ff  blueviolet 8a2be2
brown a52a2a  burlywood deb887  cadetblue 5f9ea0  chartreuse 7fff00  chocolate d2691e
coral ff7f50  cornflowerblue 6495ed  cornsilk fff8dc  crimson dc143c  cyan 00ffff
darkblue 00008b  darkcyan 008b8b  darkgoldenrod b8860b  darkgray a9a9a9  darkgreen 006400
darkgrey a9a9a9  darkkhaki bdb76b  darkmagenta 8b008b  darkolivegreen 556b2f  darkorange ff8c00
darkorchid 9932cc  darkred 8b0000  darksalmon e9967a  darkseagreen 8fbc8f  darkslateblue 483d8b
darkslategray 2f4f4f  darkslategrey 2f4f4f  darkturquoise 00ced1  darkviolet 9400d3
deeppink ff1493  deepskyblue 00bfff  dimgray 696969  dimgrey 696969  dodgerblue 1e90ff
firebrick b22222  floralwhite fffaf0  forestgreen 228b22  fuchsia ff00ff  gainsboro dcdcdc
ghostwhite f8f8ff  gold ffd700  goldenrod daa520  gray 808080  green 008000  greenyellow adff2f
grey 808080  honeydew f0fff0  hotpink ff69b4  indianred cd5c5c  indigo 4b0082  ivory fffff0
khaki f0e68c  lavender e6e6fa  lavenderblush fff0f5  lawngreen 7cfc00  lemonchiffon fffacd
lightblue add8e6  lightcoral f08080  lightcyan e0ffff  lightgoldenrodyellow fafad2
lightgray d3d3d3  lightgreen 90ee90  lightgrey d3d3d3  lightpink ffb6c1  lightsalmon ffa07a
lightseagreen 20b2aa  lightskyblue 87cefa  lightslategray 778899  lightslategrey 778899
lightsteelblue b0c4de  lightyellow ffffe0  lime 00ff00  limegreen 32cd32  linen faf0e6
magenta ff00ff  maroon 800000  mediumaquamarine 66cdaa  mediumblue 0000cd  mediumorchid ba55d3
mediumpurple 9370db  mediumseagreen 3cb371  mediumslateblue 7b68ee  mediumspringgreen 00fa9a
mediumturquoise 48d1cc  mediumvioletred c71585  midnightblue 191970  mintcream f5fffa
mistyrose ffe4e1  moccasin ffe4b5  navajowhite ffdead  navy 000080  oldlace fdf5e6  olive 808000
olivedrab 6b8e23  orange ffa500  orangered ff4500  orchid da70d6  palegoldenrod eee8aa
palegreen 98fb98  paleturquoise afeeee  palevioletred db7093  papayawhip ffefd5
peachpuff ffdab9  peru cd853f  pink ffc0cb  plum dda0dd  powderblue b0e0e6  purple 800080
rebeccapurple 663399  red ff0000  rosybrown bc8f8f  royalblue 4169e1  saddlebrown 8b4513
salmon fa8072  sandybrown f4a460  seagreen 2e8b57  seashell fff5ee  sienna a0522d  silver c0c0c0
skyblue 87ceeb  slateblue 6a5acd  slategray 708090  slategrey 708090  snow fffafa
springgreen 00ff7f  steelblue 4682b4  tan d2b48c  teal 008080  thistle d8bfd8  tomato ff6347
turquoise 40e0d0  violet ee82ee  wheat f5deb3  white ffffff  whitesmoke f5f5f5  yellow ffff00
yellowgreen 9acd32
"""

_WORDS = _TABLE.split()

#: Name in lower case to "#rrggbb".
NAMES: dict[str, str] = {
    name: "#" + digits for name, digits in zip(_WORDS[::2], _WORDS[1::2], strict=True)
}


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

_HEX = re.compile(r"#([0-9a-f]{3,4}|[0-9a-f]{6}|[0-9a-f]{8})\Z", re.IGNORECASE)
_FUNCTION = re.compile(r"(rgb|hsl)a?\(([^()]*)\)\Z", re.IGNORECASE)
_DEGREES = {"deg": 1.0, "grad": 0.9, "rad": 180.0 / pi, "turn": 360.0, "": 1.0}  #: of each unit
_ANGLE = re.compile(r"([-+]?[\d.]+(?:e[-+]?\d+)?)(deg|grad|rad|turn|)\Z", re.IGNORECASE)


def parse_colour(text: str) -> str:
    """The colour of "#RGB", "#RRGGBBAA", "rgb(255, 0, 0)", "hsl(0 100% 50%)" or a CSS name.

    How much shows through it is not looked at: `is_transparent`. Raises ValueError for anything
    else.
    """
    word = text.strip()
    if _HEX.match(word):
        digits = word[1:].lower()
        return "#" + (digits[:6] if len(digits) >= 6 else "".join(d + d for d in digits[:3]))
    if word.lower() in NAMES:
        return NAMES[word.lower()]
    kind, numbers = _numbers(word)
    if kind == "rgb" and len(numbers) >= 3:
        shares = ((c, 100) if c.endswith("%") else (c, 255) for c in numbers[:3])
        return _hex([min(max(float(c.removesuffix("%")) / whole, 0.0), 1.0) for c, whole in shares])
    if kind == "hsl" and len(numbers) >= 3 and (angle := _ANGLE.match(numbers[0])):
        hue = float(angle[1]) * _DEGREES[angle[2].lower()] / 360.0
        saturation, lightness = (
            min(max(float(c.rstrip("%")) / 100, 0.0), 1.0) for c in numbers[1:3]
        )
        return _hex([round(c, 9) for c in hls_to_rgb(hue % 1.0, lightness, saturation)])
    raise ValueError(f"found {text!r}, expected #RRGGBB, rgb(r, g, b) or the name of a colour")


def is_transparent(text: str) -> bool:
    """Whether nothing shows of a colour: "transparent", or one whose alpha is 0."""
    word = text.strip().lower()
    if _HEX.match(word):
        digits = word[1:]
        return len(digits) in (4, 8) and int(digits[3 if len(digits) == 4 else 6 :], 16) == 0
    _, numbers = _numbers(word)
    with suppress(ValueError):
        return word == "transparent" or (len(numbers) > 3 and float(numbers[3].rstrip("%")) <= 0.0)
    return False


def _numbers(word: str) -> tuple[str, list[str]]:
    """The function that a colour is, rgb or hsl, and its numbers."""
    match = _FUNCTION.match(word)
    if match is None:
        return "", []
    return match[1].lower(), [c for c in re.split(r"[\s,/]+", match[2].strip()) if c]


def _hex(channels: list[float]) -> str:
    return "#" + "".join(f"{round(c * 255):02x}" for c in channels)


def channels_of(colour: str) -> tuple[float, float, float]:
    """Red, green and blue of "#rrggbb", each in [0, 1]."""
    red, green, blue = (int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5))
    return red, green, blue


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
    channels = channels_of(colour)
    value, span = max(channels), max(channels) - min(channels)  # 0 for a grey
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


def key_of(lines: Contour | Dashed, table: Collection[str]) -> str | None:
    """The key of `table` that stands for lines of a drawing by their look; None if there is none.

    The keys are layer names (any case) and colours ("red", "#0000FF"). The layer decides before
    the colour, an equal colour before one that is only near in hue. `OTHERS` stands for what none
    of the keys before it does, so that no key behind it counts.
    """
    return _key_of(lines.layer, lines.colour, tuple(table))


@cached("drawings.looks")
def _key_of(layer: str | None, colour: str | None, table: tuple[str, ...]) -> str | None:
    named = list(takewhile(lambda key: key != OTHERS, table))
    if layer is not None:
        name = layer.casefold()
        for key in named:
            if key.casefold() == name:
                return key
    nearest = None
    if colour is not None:
        colours = []
        for key in named:
            with suppress(ValueError):
                parse_colour(key)
                colours.append(key)
        nearest = nearest_colour(colour, colours)
    return OTHERS if nearest is None and OTHERS in table else nearest
