"""The setup sheet as one HTML file: nothing is fetched, and it works from a disk.

header, verdict, hash -> playback with the program's text -> pictures -> operations, tools, bar
"""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from beamcam.model.plan import clock
from beamcam.pictures.bar import BarMade
from beamcam.pictures.svg import inline_svg
from beamcam.setup_sheet.content import Content
from beamcam.setup_sheet.html import (
    length,
    messages,
    number,
    page_script,
    page_style,
    row,
    shown,
    table,
    used_columns,
)
from beamcam.setup_sheet.operations import Operation
from beamcam.setup_sheet.playback import as_script, bar_data, table_data
from beamcam.setup_sheet.solid_data import CHORDS, Solids, solids_of
from beamcam.simulate.trace import TraceAxis
from beamcam.version import __version__

MAX_TEXT = 1_500_000  #: characters of a program that the page holds
HEAD_LINES = 200  #: that it shows of a longer one
MAX_ROWS = 1000  #: operations in the table
VERDICTS = {
    "made": "Read back: the program makes exactly these parts.",
    "alone": "Read back by itself: nothing is wrong with it; no part was given to compare with.",
    "wrong": "Read back: this program is NOT RIGHT.",
}
UNIT_CHOICE = (
    '<label id="unit-choice">Unit <select id="unit"><option>mm</option><option>inch</option>'
    "</select></label>"
)
#: What the buttons that choose a view are called.
VIEW_NAMES = {
    "above": "Above", "side": "Side", "space": "In space", "table": "Table", "guide": "Guide",
}  # fmt: skip
LONG_ROWS = ("Machine file",)
MARKS = '<div id="marks"></div>'
_UNIT = '<span class="unit">mm</span>'
_RATE = '<span class="unit" data-per="min">mm/min</span>'


def verdict_of(content: Content) -> str:
    """Verdict of the read-back, in a sentence."""
    if content.verdict == "made" and (content.left_out or content.hand):
        return "Read back: the program makes these parts, but for what is left for manual work."
    return VERDICTS[content.verdict]


def setup_page(content: Content) -> str:
    """The page; the same program gives the same bytes."""
    program = content.program
    title = f"{program.name}: setup sheet"
    solids = solids_of(program, content.made)
    return "".join(
        [
            '<!doctype html>\n<html lang="en" ',
            f'data-sha256="{program.sha256}" data-unit="{content.unit}">\n',
            document_head(title),
            "<body>\n<main>\n",
            *_top(content),
            _playback(content),
            *_told(content),
            *_space(solids),
            *_pictures(content),
            *_tables(content),
            "</main>\n",
            f"<footer>beamcam {__version__}. SHA-256 of {shown(program.name)}: "
            f"<code>{program.sha256}</code></footer>\n",
            data_script("playback", playback_data(content)),
            data_script("program", program_data(content.program.data)),
            data_script("solid", {"faces": solids.faces, "pieces": solids.pieces})
            if solids.pieces
            else "",
            f"<script>{page_script()}</script>\n</body>\n</html>\n",
        ]
    )


def document_head(title: str) -> str:
    """The head of a page that fetches nothing; a browser would ask for an icon by itself."""
    return (
        '<head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        '<meta http-equiv="Content-Security-Policy" content="default-src \'none\'; '
        "style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:\">"
        f'<link rel="icon" href="data:,"><title>{shown(title)}</title>'
        f"<style>{page_style()}</style></head>\n"
    )


def data_script(name: str, data: object) -> str:
    """Data for the page's script."""
    return f'<script type="application/json" id="{name}">{as_script(data)}</script>\n'


def playback_data(content: Content) -> dict[str, Any]:
    """The trace with what it moves."""
    made = content.made
    data = bar_data(made, content.trace) if isinstance(made, BarMade) else table_data(made)
    operations = [
        {"number": op.number, "line": op.line, "what": op.what, "faces": ", ".join(op.faces)}
        for op in content.operations
    ]
    return data | {"operations": operations}


def program_data(data: bytes) -> dict[str, Any]:
    """The program's text, so that the page can prove its hash; of a long one the first lines."""
    try:
        text = data.decode("utf-8")
    except UnicodeDecodeError:
        return {"text": None, "lines": ["(bytes that are no text)"]}
    if len(text) > MAX_TEXT:
        lines = text[: 200 * HEAD_LINES].split("\n")[:HEAD_LINES]
        more = text.count("\n") - len(lines)
        return {"text": None, "lines": [*lines, f"({more} more lines)"]}
    return {"text": text}


def _top(content: Content) -> Iterator[str]:
    program = content.program
    # The heading has the program's name already. Long rows stand below the others.
    header = sorted(
        (row for row in content.header if row[0] != "Program"), key=lambda row: row[0] in LONG_ROWS
    )
    rows = "".join(
        f"<dt>{label}</dt><dd{' class=wide' if label in LONG_ROWS else ''}>{shown(value)}</dd>"
        for label, value in header
    )
    yield (
        f'<div class="top"><h1>{shown(program.name)}</h1>{UNIT_CHOICE}</div>\n'
        f"<dl>{rows}<dt>SHA-256</dt><dd class=wide><code>{program.sha256}</code></dd></dl>\n"
        f'<div class="verdict {content.verdict}">{verdict_of(content)}'
    )
    if content.ledger:
        yield f" {shown(content.ledger)}."
    below = [f'<a href="#by-hand">{count} left for manual work</a>'
             for count in (len(content.left_out) + len(content.hand),) if count]  # fmt: skip
    below += [f'<a href="#said">{count} warning{"s" if count > 1 else ""} and remarks</a>'
              for count in (len(content.messages),) if count]  # fmt: skip
    yield f" {'; '.join(below)}</div>\n"
    yield (
        '<div id="hash" role="status"><span id="hash-said">The SHA-256 of the program is not '
        'checked in this page.</span> <span id="program-check"><label>Compare a file with it: '
        '<input type="file" id="program-file"></label></span></div>\n'
    )


def _told(content: Content) -> Iterator[str]:
    """What is left for manual work, and messages."""
    if content.left_out or content.hand:
        items = "".join(f"<li>{shown(line)}</li>" for line in content.left_out)
        rows_ = _hand(content) if content.hand else ""
        yield (
            f'<section id="by-hand"><h2>Manual work</h2><ul class="hand">{items}</ul>{rows_}'
            "</section>\n"
        )
    if content.messages:
        said = messages(content.messages)
        yield f'<section id="said"><h2>Warnings and remarks</h2>{said}</section>\n'


def _hand(content: Content) -> str:
    """The marks that are made manually."""
    heads = (("Part", False), ("Mark", False), ("Face", False), (f"X, {_UNIT}", True),
             (f"Y, {_UNIT}", True), (f"Height, {_UNIT}", True), ("Pieces", True))  # fmt: skip
    cells = [
        [shown(h["mark"]), shown(f"{h['kind']} {h['text']}".strip()), shown(h["face"]),
         length(h["x"]), length(h["y"]), length(h["height"]) if h["height"] else "",
         str(h["pieces"])]
        for h in content.hand
    ]  # fmt: skip
    used, cells = used_columns(heads, cells)
    return table("hand", used, map(row, cells))


def _playback(content: Content) -> str:
    views = {"above": "The bar from above", "side": "The bar from the side",
             "space": "The bar and the tools in space; drag or arrow keys turn it"}  # fmt: skip
    is_bar = content.program.machine.stock == "beam"
    if content.program.machine.stock == "profile":
        views = {"table": "The way of the torch along the bar and round it, unrolled"}
    elif not is_bar:
        views = {"table": "The way of the head over the table"}
    return playback_section(content.trace.axes, views, True, is_bar)


def unit_of(axis: TraceAxis) -> str:
    """The unit of an axis; of a length the one that the reader chose."""
    return _UNIT if axis.unit == "mm" else axis.unit


def canvases(views: Mapping[str, str], is_one: bool = False) -> str:
    """What the views are drawn on, by their names and labels; `is_one` shows the first alone."""
    return "".join(
        f'<canvas data-view="{name}" role="img" aria-label="{label}" tabindex="0"'
        f"{' hidden' if is_one and k else ''}></canvas>"
        for k, (name, label) in enumerate(views.items())
    )


def axis_table(axes: Iterable[TraceAxis]) -> str:
    """The table of the axes, whose figures the page's script fills in."""
    rows = "".join(
        f'<tr><th scope="row">{shown(axis.name)}</th><td class="n"><data id="axis-{k}" value="0">'
        f"0</data></td><td>{unit_of(axis)}</td></tr>"
        for k, axis in enumerate(axes)
    )
    return f'<table class="axes"><tbody>{rows}</tbody></table>'


def playback_section(axes: Any, views: dict[str, str], listing: bool, whole: bool) -> str:
    """The view, its slider and beside it the controls, what follows, the axes and the program.

    `listing` is of a program, which has operations and marks on the slider; `whole` is the choice
    of the whole length.
    """
    choice = '<label><input type="checkbox" id="whole"> whole length</label>' if whole else ""
    shows = "".join(
        f'<button data-show="{name}" aria-pressed="{"false" if k else "true"}">'
        f"{VIEW_NAMES[name]}</button>"
        for k, name in enumerate(views)
        if len(views) > 1
    )
    zoom = (
        '<button data-zoom="in" aria-label="Nearer">+</button>'
        '<button data-zoom="out" aria-label="Further off">&minus;</button>'
        '<button data-zoom="fit">Fit</button>'
    )
    text = (
        '<div id="listing" role="listbox" tabindex="0" aria-label="Program; up and down step '
        'by block"></div>'
        if listing
        else ""
    )
    follows = (
        '<div id="next"><div id="last-what"></div><div id="next-when"></div>'
        '<div id="next-what"></div></div>'
        if listing
        else ""
    )
    speeds = "".join(
        f'<option value="{v}"{" selected" if v == "1" else ""}>{v} x</option>'
        for v in ("0.1", "0.5", "1", "2", "5", "10", "50", "200")
    )
    return (
        '<section class="playback"><h2>Playback</h2><div class="stage"><div class="views">'
        f'<div class="controls looking">{shows}{zoom if listing else ""}{choice}</div>'
        f"{canvases(views, True)}"
        f'<div class="slider">{MARKS if listing else ""}<input type="range" id="time" min="0" '
        'max="1" step="any" value="0" aria-label="Time"></div></div>'
        '<div class="panel"><div class="controls">'
        '<button id="first" aria-label="To the beginning">|&lt;</button>'
        '<button id="back" aria-label="One block back">&lt;</button>'
        '<button id="play" aria-pressed="false">Play</button>'
        '<button id="forward" aria-label="One block forward">&gt;</button>'
        f'<label>Speed <select id="speed">{speeds}</select></label>'
        f'<span id="clock"></span></div>{follows}<div id="state"></div>{axis_table(axes)}{text}'
        "</div></div></section>\n"
    )


def _space(solids: Solids) -> Iterator[str]:
    """The solid, or why there is none."""
    yield '<section class="in-space"><h2>The pieces in space</h2>\n'
    if not solids.pieces:
        yield f"<p>No solid: {shown(solids.without)}.</p></section>\n"
        return
    names = [(-1, "all"), *((k, p["mark"] or p["kind"]) for k, p in enumerate(solids.pieces))]
    buttons = "".join(
        f'<button data-piece="{k}" aria-pressed="{"true" if k < 0 else "false"}">{shown(name)}'
        "</button>"
        for k, name in names
        if len(names) > 2
    )
    letters = "".join(
        f'<span class="face-letter" data-face="{f}" hidden>{f}</span>' for f in solids.faces
    )
    coarse = ""
    if solids.chord > CHORDS[0]:
        coarse = (
            f" Circles have fewer sides, up to {solids.chord:g} mm within them, to keep the page "
            "small; every hole is there."
        )
    yield (
        f'<div class="controls">{buttons}'
        '<button data-solid="in" aria-label="Nearer">+</button>'
        '<button data-solid="out" aria-label="Further off">&minus;</button>'
        '<button data-solid="fit">Fit</button></div>'
        '<div id="solid-view" tabindex="0" role="group" aria-label="What the program leaves, in '
        'space: drag or arrow keys turn it, shift moves it, plus and minus zoom">'
        f'<canvas role="img" aria-label="The pieces"></canvas>{letters}</div>'
        '<p class="hint">As the program makes it. Drag or arrow keys turn it, with shift they move '
        "it; plus and minus, or the wheel after a click, zoom. A click on a hole goes to its "
        f"operation, a click on an operation to its hole.{coarse}</p></section>\n"
    )


def _pictures(content: Content) -> Iterator[str]:
    yield '<section class="pictures"><h2>What the program makes</h2>\n'
    for k, scene in enumerate(content.pictures):
        if k == 1:
            yield "<h2>Parts</h2>\n"
        yield (
            f'<div class="picture" role="group" tabindex="0" aria-label="{shown(scene.title)}">'
            f"{inline_svg(scene)}</div>\n"
        )
    yield "</section>\n"


def _tables(content: Content) -> Iterator[str]:
    if content.bar:
        heads = (("What", False), (f"From, {_UNIT}", True), (f"To, {_UNIT}", True),
                 (f"Length, {_UNIT}", True))  # fmt: skip
        rows = (
            row([shown(s.what), length(s.start), length(s.end), length(s.end - s.start)])
            for s in content.bar
        )
        yield f"<section><h2>Bar</h2>{table('bar', heads, rows)}</section>\n"
    if content.tools:
        tools = (("Where", False), ("Station", False), ("Tool", False))
        cells = [[shown(t.where), shown(t.station), shown(t.tool)] for t in content.tools]
        used, cells = used_columns(tools, cells)
        made = table("tools", used, map(row, cells))
        yield f"<section><h2>Tools to load</h2>{made}</section>\n"
    yield _times(content)
    yield _operations(content)


def _times(content: Content) -> str:
    """Work and travel by tool."""
    heads = (("What", False), ("Operations", True), ("At work, s", True), ("In all, s", True),
             (f"Length, {_UNIT}", True))  # fmt: skip
    cells = [
        [shown(t.what), "" if t.count is None else str(t.count),
         number(t.work_s, "s") if t.work_s else "", number(t.seconds, "s"), length(t.length)]
        for t in content.totals
    ]  # fmt: skip
    used, cells = used_columns(heads, cells)
    return f"<section><h2>Time by tool</h2>{table('times', used, map(row, cells))}</section>\n"


def _operations(content: Content) -> str:
    is_bar = content.program.machine.stock == "beam"
    heads = [("No.", True), ("Operation", False), *([("Face", False)] if is_bar else []),
             (f"X, {_UNIT}", True), (f"Y, {_UNIT}", True),
             *([(f"Depth, {_UNIT}", True)] if is_bar else [(f"Length, {_UNIT}", True)]),
             (f"Feed, {_RATE}", True), *([("Speed, rpm", True)] if is_bar else []),
             ("Time, s", True)]  # fmt: skip
    cells = [_operation(op, is_bar) for op in content.operations[:MAX_ROWS]]
    used, cells = used_columns(heads, cells)
    rows = [
        row(line, f" data-line={op.line}")
        for line, op in zip(cells, content.operations, strict=False)
    ]
    more = len(content.operations) - len(rows)
    note = f"<p>{more} more operations are not listed.</p>" if more > 0 else ""
    return (
        f"<section><h2>Operations ({len(content.operations)}, {clock(content.seconds)})</h2>"
        f"{table('operations', used, rows)}{note}</section>\n"
    )


def _operation(op: Operation, is_bar: bool) -> list[str]:
    """The cells of an operation."""
    button = f"<button data-line={op.line}>{op.number}</button>"
    deep = "through" if op.is_through else length(op.depth)
    return [button, shown(op.what), *([", ".join(op.faces)] if is_bar else []), length(op.x),
             length(op.y), deep if is_bar else length(op.length),
             length(op.feed_mm_min),
             *([number(op.speed_rpm)] if is_bar else []), number(op.seconds, "s")]  # fmt: skip
