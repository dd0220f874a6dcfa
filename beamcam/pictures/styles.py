"""The styles of pictures: how a class of shapes is drawn, on paper and in the dark."""

from msgspec import Struct


class Style(Struct, frozen=True):
    """Colours as #rrggbb; none is not drawn."""

    stroke: str | None = None
    fill: str | None = None
    width: float = 1.0
    dash: tuple[float, ...] = ()
    dark_stroke: str | None = None  #: on a dark page; as `stroke` where it is not said
    dark_fill: str | None = None
    bold: bool = False


INK, PALE = "#1c2530", "#e8ecf1"
DARK_INK, DARK_PALE = "#e6ebf2", "#2a333f"

#: Colours of tools, told apart by people who do not see red or green too (Okabe and Ito).
TOOL_COLOURS = (
    ("#0072b2", "#56b4e9"), ("#d55e00", "#ff8a3c"), ("#00795a", "#2ec4a0"), ("#b0478a", "#e38bc4"),
    ("#8a6d00", "#e3c23a"), ("#4b4bb3", "#9a9aff"), ("#7a3b12", "#c98a5c"), ("#3d5a66", "#9fbecb"),
)  # fmt: skip

#: From slow to fast (viridis, without its palest end).
SPEED_COLOURS = (
    ("#440154", "#b07cc6"), ("#46327e", "#9d8fe0"), ("#365c8d", "#7fb0e6"), ("#277f8e", "#5cc4d1"),
    ("#1f8a70", "#43cfa6"), ("#3f9e4d", "#74dd7f"), ("#7a9a1f", "#b8dc4a"), ("#a58a00", "#f5dc3c"),
)  # fmt: skip


def _line(colour: str, dark: str, width: float = 1.0, dash: tuple[float, ...] = ()) -> Style:
    return Style(colour, None, width, dash, dark)


def _text(colour: str = INK, dark: str = DARK_INK, bold: bool = False) -> Style:
    return Style(None, colour, dark_fill=dark, bold=bold)


STYLES: dict[str, Style] = {
    "paper": Style(None, "#ffffff", dark_fill="#12171d"),
    "face": Style(INK, "#f4f6f9", 1.2, (), DARK_INK, "#1c232c"),
    "part": Style(INK, "#dfe9f5", 1.0, (), DARK_INK, "#22364d"),
    "trim": Style("#8a5a00", "#f6e7c8", 0.8, (), "#e0b050", "#3d3320"),
    "remnant": Style("#59636e", "#ffffff", 0.8, (6.0, 3.0), "#9aa5b1", "#181e25"),
    "stock": _line("#59636e", "#9aa5b1", 0.8, (6.0, 3.0)),
    "outer": Style(INK, "#f4f6f9", 1.2, (), DARK_INK, "#1c232c"),
    "inner": Style(INK, "#ffffff", 1.0, (), DARK_INK, "#12171d"),
    "open": _line("#b3261e", "#ff8a80", 1.0),
    "hole": Style("#0072b2", "#ffffff", 1.0, (), "#56b4e9", "#12171d"),
    "slot": Style("#0072b2", "#ffffff", 1.0, (), "#56b4e9", "#12171d"),
    "thread": _line("#0072b2", "#56b4e9", 0.6, (3.0, 2.0)),
    "mark": _line("#00795a", "#2ec4a0", 1.0),
    "engrave": _line("#7a3b12", "#c98a5c", 1.0),
    "punch": _line("#00795a", "#2ec4a0", 1.0, (1.5, 2.0)),
    "powder": _line("#7a5af0", "#b5a4ff", 1.0, (4.0, 2.0)),
    "ignored": _line("#8d99a6", "#75828f", 0.8, (2.0, 3.0)),
    "bend": _line("#7a5af0", "#b5a4ff", 1.0, (8.0, 3.0, 2.0, 3.0)),
    "cut": _line("#b3261e", "#ff8a80", 1.8),
    "cut-edge": _line("#b3261e", "#ff8a80", 1.0),
    "section": Style(INK, "#c9d3df", 1.0, (), DARK_INK, "#3a4756"),
    "guide": _line("#8d99a6", "#75828f", 0.5, (2.0, 3.0)),
    "datum": _line(INK, DARK_INK, 2.4),
    "dim": _line("#59636e", "#9aa5b1", 0.6),
    "figure": _text("#3f4a56", "#c3ccd6"),
    "text": _text("#7a3b12", "#c98a5c"),
    "label": _text(),
    "heading": _text(bold=True),
    "number": _text("#1c2530", "#e6ebf2", True),
    "rapid": _line("#8d99a6", "#75828f", 0.8, (4.0, 3.0)),
    "lead": _line("#ffb000", "#7a5a10", 5.0),
    "pierce": Style("#b3261e", "#ffffff", 1.4, (), "#ff8a80", "#12171d"),
    "stop": _line("#4b4bb3", "#9a9aff", 1.0),
    "grid": _line("#d5dbe2", "#333d49", 0.6),
    "axis": _line("#3f4a56", "#c3ccd6", 1.0),
    "position": _line("#00795a", "#2ec4a0", 1.6),
    "velocity": _line("#0072b2", "#56b4e9", 1.6),
    "acceleration": _line("#b3261e", "#ff8a80", 1.6),
    "true": _line("#59636e", "#9aa5b1", 1.4),
    "stair": _line("#0072b2", "#56b4e9", 1.8),
    "off": Style("#b3261e", None, 1.8, (), "#ff8a80"),
    "gone": Style("#b3261e", None, 1.6, (4.0, 2.0), "#ff8a80"),
    "new": Style("#00795a", None, 1.8, (), "#2ec4a0"),
    "moved": _line("#7a5af0", "#b5a4ff", 1.6),
    "same": Style("#7d8996", None, 0.8, (), "#75828f"),
    "gone-text": _text("#b3261e", "#ff8a80"),
    "new-text": _text("#00795a", "#2ec4a0"),
    "same-text": _text("#59636e", "#9aa5b1"),
    **{f"tool-{k}": Style(c, "#ffffff", 1.6, (), d, "#12171d")
       for k, (c, d) in enumerate(TOOL_COLOURS)},
    **{f"path-{k}": _line(c, d, 1.4) for k, (c, d) in enumerate(TOOL_COLOURS)},
    **{f"speed-{k}": _line(c, d, 1.5) for k, (c, d) in enumerate(SPEED_COLOURS)},
}  # fmt: skip


def style_of(classes: str) -> Style:
    """The style of the first class. Raises KeyError for one that has none."""
    return STYLES[classes.split(" ", 1)[0]]


def css(prefix: str = "", dark: bool = False) -> str:
    """The styles as rules of CSS, each behind `prefix`; `dark` as they are on a dark page."""
    lines = []
    for name, s in STYLES.items():
        stroke = (s.dark_stroke if dark else None) or s.stroke
        fill = (s.dark_fill if dark else None) or s.fill
        rule = f"fill:{fill or 'none'}"
        if stroke:
            rule += f";stroke:{stroke}"
            if not dark:
                rule += f";stroke-width:{s.width:g}"
                if s.dash:
                    rule += f";stroke-dasharray:{' '.join(f'{d:g}' for d in s.dash)}"
        if s.bold and not dark:
            rule += ";font-weight:bold"
        lines.append(f"{prefix}.{name}{{{rule}}}")
    return "".join(lines)
