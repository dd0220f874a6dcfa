"""The setup sheet as one HTML file: nothing is fetched, and it works from a disk.

header, verdict, hash -> playback with the program's text -> pictures -> operations, tools, bar
"""

from typing import Any

from beamcam.checks.rules import MANUAL_WORK
from beamcam.pictures.formats import inline_svg
from beamcam.pictures.scene import SPEED_COLOURS, css
from beamcam.planning.coping.rules import ROUNDED
from beamcam.reports.run import as_message, message_line
from beamcam.reports.templates import as_it_stands, static_text, template
from beamcam.setup_sheet.content import SheetContent
from beamcam.setup_sheet.playback import as_script, playback_data
from beamcam.setup_sheet.solid_data import CHORDS, solids_of
from beamcam.setup_sheet.tables import manual_work, tables_of

SCRIPTS = (
    "sha256", "numbers", "trace", "canvas", "gestures", "cell", "table", "guide", "listing",
    "mesh", "solid", "sheet",
)  # fmt: skip


def page(name: str, **values: object) -> str:
    """A page by its template; the same values give the same bytes.

    Templates get the values, and as functions `style`, `script` (of all pages, and of one by its
    name), `data`, `picture` and `message`.
    """
    return template("setup_sheet", name).render(
        values, style=_style, script=_script, picture=lambda s: as_it_stands(inline_svg(s)),
        data=lambda value: as_it_stands(as_script(value)),
        message=lambda one: message_line(as_message(one)),
    )  # fmt: skip


def _script(name: str = "") -> object:
    """A script by its name; without one all that move things, in their order."""
    if name:
        return static_text("setup_sheet", f"{name}.js")
    parts = "\n".join(static_text("setup_sheet", f"{one}.js") for one in SCRIPTS)
    return as_it_stands(f'"use strict";\n{parts}')


def _style() -> object:
    """The style of a page and of the pictures in it, in the light and in the dark."""
    light = "".join(f"--speed-{k}:{c};" for k, (c, _) in enumerate(SPEED_COLOURS))
    dark = "".join(f"--speed-{k}:{d};" for k, (_, d) in enumerate(SPEED_COLOURS))
    return as_it_stands(
        f"{static_text('setup_sheet', 'page.css')}:root{{{light}}}"
        f"svg text{{font-family:system-ui,sans-serif}}{css('svg ')}\n"
        f"@media screen and (prefers-color-scheme: dark){{:root{{{dark}}}{css('svg ', dark=True)}}}"
    )


MAX_TEXT = 1_500_000  #: characters of a program that the page holds
HEAD_LINES = 200  #: that it shows of a longer one
VERDICTS = {
    "made": "Read back: the program makes exactly these parts.",
    "alone": "Read back by itself: nothing is wrong with it; no part was given to compare with.",
    "wrong": "Read back: this program is NOT RIGHT.",
}
LONG_ROWS = ("Machine file",)
VIEWS = {
    "beam": {
        "above": "The bar from above", "side": "The bar from the side",
        "space": "The bar and the tools in space; drag or arrow keys turn it",
    },
    "profile": {"table": "The way of the torch along the bar and round it, unrolled"},
    "sheet": {"table": "The way of the head over the table"},
}  # fmt: skip


def verdict_of(content: SheetContent) -> str:
    """Verdict of the read-back, in a sentence."""
    if content.verdict != "made":
        return VERDICTS[content.verdict]
    codes = {diagnostic.code for diagnostic in content.messages}
    manual_work = content.left_out or content.hand or MANUAL_WORK.code in codes
    missing = ["what is left for manual work"] if manual_work else []
    # Whether a coper had sharp corners to round is known from a plan only.
    is_coped = content.program.machine.coper is not None and not content.ledger
    if ROUNDED.code in codes or is_coped:
        missing.append("corners that are cut round")
    if not missing:
        return VERDICTS["made"]
    return f"Read back: the program makes these parts, but for {' and '.join(missing)}."


def setup_page(content: SheetContent) -> str:
    """The page; the same program gives the same bytes."""
    program = content.program
    solids = solids_of(program, content.made)
    operations = [
        {"number": op.number, "line": op.line, "what": op.what, "faces": ", ".join(op.faces)}
        for op in content.operations
    ]
    # The heading has the program's name already. Long rows stand below the others.
    header = [(label, value, label in LONG_ROWS)
              for label, value in content.header if label != "Program"]  # fmt: skip
    return page(
        "sheet", title=f"{program.name}: setup sheet", content=content, program=program,
        header=sorted(header, key=lambda row: row[2]), verdict=verdict_of(content),
        said=content.messages, hand=manual_work(content), tables=list(tables_of(content)),
        views=VIEWS[program.machine.stock], is_bar=program.machine.stock == "beam",
        solids=solids, is_coarse=solids.chord > CHORDS[0],
        playback=playback_data(content.made, content.trace) | {"operations": operations},
        text=program_data(program.data),
    )  # fmt: skip


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
