"""Two parts or two programs compared, as one HTML file that fetches nothing."""

from collections.abc import Sequence

from beamcam.diff.pairing import Difference
from beamcam.pictures.comparison import Compared
from beamcam.pictures.scene import Unit
from beamcam.pictures.svg import inline_svg
from beamcam.setup_sheet.html import shown
from beamcam.setup_sheet.page import document_head
from beamcam.setup_sheet.static_files import static_text
from beamcam.version import __version__

MAX_LISTED = 2000  #: differences in the list
SHOWN = (("same", "what is the same"), ("gone", "A"), ("new", "B"), ("moved", "arrows"))


def diff_page(
    names: tuple[str, str],
    pictures: Sequence[Compared],
    differences: Sequence[Difference],
    unit: Unit = "mm",
) -> str:
    """The page: counts, pictures with what is to be seen of them, the differences in words."""
    title = f"{names[0]} and {names[1]}"
    sums = [sum(getattr(p, how) for p in pictures) for how in ("same", "changed", "gone", "new")]
    counts = "{} the same, {} changed, {} gone, {} new".format(*sums)
    choices = "".join(
        f'<label><input type="checkbox" checked data-shows="{style}"> {text}</label>'
        for style, text in SHOWN
    )
    drawn = "".join(
        f'<div class="picture" role="group" tabindex="0" aria-label="{shown(p.scene.title)}">'
        f"{inline_svg(p.scene)}</div>\n"
        for p in pictures
    )
    listed = "".join(f"<li>{shown(d.text)}</li>" for d in differences[:MAX_LISTED])
    more = len(differences) - MAX_LISTED
    rest = f"<p>{more} more differences are not listed.</p>" if more > 0 else ""
    said = f"<ol>{listed}</ol>{rest}" if listed else "<p>They mean the same.</p>"
    verdict = "wrong" if differences else "made"
    noun = "difference" if len(differences) == 1 else "differences"
    return (
        f'<!doctype html>\n<html lang="en" data-unit="{unit}">\n{document_head(title)}'
        f"<body><main>\n<h1>A: {shown(names[0])}<br>B: {shown(names[1])}</h1>\n"
        f'<p class="verdict {verdict}">{len(differences)} {noun}; {counts}</p>\n'
        f'<div class="controls">Show {choices}</div>\n'
        f'<section class="pictures">{drawn}</section>\n<h2>Differences</h2>{said}\n</main>\n'
        f"<footer>beamcam {__version__}</footer>\n"
        f'<script>"use strict";\n{static_text("shows.js")}</script></body></html>\n'
    )
