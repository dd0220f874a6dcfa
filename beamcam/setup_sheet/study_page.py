"""What an encoder reads of a program, as one HTML file that fetches nothing."""

from beamcam.pictures.encoder import Study, encoder_scene
from beamcam.pictures.svg import inline_svg
from beamcam.setup_sheet.html import shown
from beamcam.setup_sheet.page import document_head
from beamcam.version import __version__


def study_page(study: Study) -> str:
    """The page: the figures of the study, and the staircase about the worst corner."""
    encoder, scene = study.encoder, encoder_scene(study)
    title = f"{study.name}: encoder"
    rows = "".join(
        f'<tr><th scope="row">{name}</th><td>{shown(value)}</td></tr>'
        for name, value in study.figures()
    )
    return (
        f'<!doctype html>\n<html lang="en">\n{document_head(title)}<body><main>\n'
        f"<h1>{shown(title)}</h1>\n"
        f"<p>{encoder.shown}, on each axis of "
        f"{shown(study.machine)}. An encoder shows the count that the axis has passed last: the "
        "true point lies within a count above what is read.</p>\n"
        f"<table><tbody>{rows}</tbody></table>\n"
        f'<section class="pictures"><div class="picture" role="group" tabindex="0" '
        f'aria-label="{shown(scene.title)}">{inline_svg(scene)}</div></section>\n</main>\n'
        f"<footer>beamcam {__version__}. SHA-256 of {shown(study.name)}: "
        f"<code>{study.sha256}</code></footer></body></html>\n"
    )
