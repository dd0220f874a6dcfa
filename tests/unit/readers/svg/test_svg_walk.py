"""Structure and style: which shapes are cut, in which colour, on which layer."""

from pathlib import Path

import pytest

from beamcam import readers
from beamcam.errors import Severity
from beamcam.model.lengths import total_length
from beamcam.readers import svg
from beamcam.readers.svg import rules
from beamcam.readers.svg.tree import Element, looks_like
from beamcam.readers.svg.walk import layer_of
from tests.conftest import SAMPLES, rules_of
from tests.svg_text import PAGE, codes, drawing, length_of, read

GOOD = sorted((SAMPLES / "svg").glob("*.svg"))
BAD = sorted((SAMPLES / "bad" / "svg").glob("*.svg"))
XLINK = PAGE + ' xmlns:xlink="http://www.w3.org/1999/xlink"'


def colours(body: str) -> list[str | None]:
    return [c.colour for c in read(body).parts[0].contours]


def layers(body: str, head: str = PAGE) -> list[str | None]:
    return [c.layer for c in read(body, head).parts[0].contours]


# --- files ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("path", BAD, ids=lambda path: path.stem)
def test_each_bad_sample_is_refused_with_its_code(path: Path) -> None:
    reading = readers.read(path.read_bytes(), path.name)
    assert reading.refused
    assert path.stem in [d.code for d in reading.diagnostics]


def test_there_is_a_bad_sample_for_each_error() -> None:
    errors = {rule.code for rule in rules_of(rules) if rule.severity is Severity.ERROR}
    assert errors - {path.stem for path in BAD} == set()


@pytest.mark.parametrize("path", GOOD, ids=lambda path: path.stem)
def test_each_good_sample_is_read(path: Path) -> None:
    reading = readers.read(path.read_bytes(), path.name)
    assert (reading.format, reading.refused, len(reading.parts)) == ("svg", False, 1)
    (part,) = reading.parts
    assert part.mark == path.stem
    assert (part.profile.code, part.profile.web_thickness) == ("B", None)
    assert all(c.face == "v" and c.source.line and c.colour for c in part.contours)


def test_what_looks_like_svg() -> None:
    assert all(looks_like(path.read_bytes()) for path in GOOD)
    assert looks_like(b"\xef\xbb\xbf<?xml version='1.0'?><!-- x --><s:svg xmlns:s='x'>")
    assert not looks_like(b"<html>")
    assert not looks_like(b"0\nSECTION\n")


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "latin-1"])
def test_encodings(encoding: str) -> None:
    declared = encoding.removesuffix("-sig")
    text = (
        f'<?xml version="1.0" encoding="{declared}"?>'
        + drawing('<g id="Ätzen"><line x2="5"/></g>').decode()
    )
    (part,) = svg.read(text.encode(encoding), "a.svg").parts
    assert next(part.contours).layer == "Ätzen"


def test_a_byte_order_mark_outweighs_a_wrong_declaration() -> None:
    text = '<?xml version="1.0" encoding="UTF-8"?>' + drawing('<line x2="5"/>').decode()
    assert not svg.read(text.encode("utf-16"), "a.svg").refused


def test_what_is_no_xml_or_no_svg() -> None:
    (said,) = svg.read(drawing("<g>"), "a.svg").diagnostics
    assert str(said) == (
        "a.svg:3: error svg-xml: found text that is no XML (mismatched tag), expected an SVG "
        "drawing"
    )
    (said,) = svg.read(b"<html/>", "a.svg").diagnostics
    assert str(said) == "a.svg:1: error svg-not-svg: found the element 'html', expected svg"
    odd = b'<?xml version="1.0" encoding="ebcdic-zz"?><svg/>'
    assert [d.code for d in svg.read(odd, "a.svg").diagnostics] == ["svg-xml"]


def test_a_prefix_for_svg_and_elements_of_others() -> None:
    text = b"""<s:svg xmlns:s="http://www.w3.org/2000/svg" xmlns:x="urn:x" width="10mm"
      height="10mm" viewBox="0 0 10 10"><x:rect width="5" height="5"/><x:g><s:path d="M0 0h9"/>
      </x:g>
      <s:line x2="4" stroke="red"/><rect xmlns="urn:y" width="1" height="1"/></s:svg>"""
    (part,) = svg.read(text, "a.svg").parts
    assert [c.curves[0].length for c in part.contours] == [4]


# --- style ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("body", "colour"),
    [
        ('<line x2="5"/>', "#ff0000"),
        ('<line x2="5" stroke="#0000FF"/>', "#0000ff"),
        ('<line x2="5" stroke="#00f" style="stroke: lime"/>', "#00ff00"),
        ('<g stroke="blue"><line x2="5" stroke="inherit"/></g>', "#0000ff"),
        ('<g stroke="blue"><line x2="5" stroke="lime" style="stroke:inherit"/></g>', "#0000ff"),
        ('<g color="blue"><line x2="5" stroke="currentColor"/></g>', "#0000ff"),
        ('<line x2="5" stroke="rgb(0, 128, 255)"/>', "#0080ff"),
        ('<line x2="5" stroke="#ED3237 icc-color(x, 0, 1)"/>', "#ed3237"),
        ('<line x2="5" stroke="url(#g)"/>', None),
        ('<line x2="5" stroke="url(#g) blue"/>', "#0000ff"),
    ],
)
def test_the_colour_of_a_stroke(body: str, colour: str | None) -> None:
    assert codes(body) == []
    assert colours(body) == [colour]


def sheet(css: str, shape: str) -> str:
    return f'{shape}<defs><style type="text/css"><![CDATA[{css}]]></style></defs>'


@pytest.mark.parametrize(
    ("css", "shape", "colour"),
    [
        (".str0 {stroke:blue}", '<line x2="5" class="fil0 str0"/>', "#0000ff"),
        (".a{stroke:blue} .b{stroke:lime}", '<line x2="5" class="b a"/>', "#00ff00"),
        (".b{stroke:lime} .a{stroke:blue}", '<line x2="5" class="b a"/>', "#0000ff"),
        ("#k{stroke:lime} .a{stroke:blue}", '<line x2="5" class="a" id="k"/>', "#00ff00"),
        (".a{stroke:lime} line{stroke:blue}", '<line x2="5" class="a"/>', "#00ff00"),
        ("line.a{stroke:lime} .a{stroke:blue}", '<line x2="5" class="a"/>', "#00ff00"),
        (".a.b{stroke:lime} .a{stroke:blue}", '<line x2="5" class="a b"/>', "#00ff00"),
        (".a,.b{stroke:lime}", '<line x2="5" class="b"/>', "#00ff00"),
        ("*{stroke:lime}", '<line x2="5" stroke="blue"/>', "#00ff00"),
        (".a{stroke:lime !important}", '<line x2="5" class="a" style="stroke:blue"/>', "#00ff00"),
        ("/* .a{stroke:blue} */ .a{stroke:lime}", '<line x2="5" class="a"/>', "#00ff00"),
        (
            '@font-face { font-family:"Arial";src:url("#F") format(svg)} .a{stroke:lime}',
            '<line x2="5" class="a"/>',
            "#00ff00",
        ),
        (".a{stroke:lime}", '<g class="a"><line x2="5"/></g>', "#00ff00"),
    ],
)
def test_style_sheets(css: str, shape: str, colour: str) -> None:
    assert colours(sheet(css, shape)) == [colour]
    assert codes(sheet(css, shape)) == []


def test_selectors_that_are_not_understood_are_named() -> None:
    body = sheet("g + line, line {stroke:blue} a:hover {stroke:lime}", '<line x2="5"/>')
    assert [d.message for d in read(body).diagnostics] == [
        "found the style rule 'g + line', expected element, .class or #id; the rule is ignored",
        "found the style rule 'a:hover', expected element, .class or #id; the rule is ignored",
    ]
    assert colours(body) == ["#0000ff"]


@pytest.mark.parametrize("style", [
    "display:none", "visibility:hidden", "opacity:0", "stroke:none", "stroke:#f000",
    "stroke-opacity:0%", "stroke:rgb(0 0 0 / 0)",
])  # fmt: skip
@pytest.mark.parametrize(
    "selector", ["line[id]", "g + line", "line:not(.a)", "> line", "g > > line"]
)
def test_a_rule_that_is_not_understood_and_hides_is_refused(selector: str, style: str) -> None:
    (said,) = read(sheet(f"{selector} {{{style}}}", '<line x2="5" stroke="red"/>')).diagnostics
    assert (said.code, said.severity.value) == ("svg-css-hides", "error")


def test_what_hides_under_a_pointer_alone_hides_nothing() -> None:
    body = sheet("line:hover {display:none}", '<line x2="5" stroke="red"/>')
    assert [d.code for d in read(body).diagnostics] == ["svg-css-selector"]
    assert colours(body) == ["#ff0000"]


def test_a_stroke_that_is_no_colour_is_read_and_said() -> None:
    (said,) = read('<line x2="5" stroke="device-cmyk(0,1,1,0)"/>').diagnostics
    assert said.code == "svg-colour"
    assert "found stroke 'device-cmyk(0,1,1,0)', expected a colour" in said.message
    assert colours('<line x2="5" stroke="#12"/>') == [None]


@pytest.mark.parametrize(
    "style", ["stroke:none;fill:black", "stroke:none;fill:url(#g)", "stroke-opacity:0;fill:red"]
)
def test_a_fill_without_stroke_is_not_cut(style: str) -> None:
    reading = read(f'<rect width="5" height="5" style="{style}"/>')
    assert [str(d) for d in reading.diagnostics] == [
        "a.svg: warning svg-fill-only: found 1 shapes with a fill and no stroke, which are not cut"
    ]
    (part,) = reading.parts
    assert (part.features, total_length(part.measures.filled)) == ((), 20)


@pytest.mark.parametrize(
    "style",
    [
        "stroke:none",
        "display:none",
        "visibility:hidden",
        "stroke:transparent",
        "stroke:none;fill:red;fill-opacity:0",
    ],
)
def test_what_does_not_show_is_not_read(style: str) -> None:
    body = f'<line x2="9"/><g style="{style}"><rect width="5" height="5"/></g>'
    reading = read(body)
    assert [d.code for d in reading.diagnostics] == ["svg-invisible"]
    assert total_length(reading.parts[0].measures.hidden) == 20
    assert length_of(body) == 9


def test_a_visible_child_of_a_hidden_group_shows_unless_it_is_not_displayed() -> None:
    assert length_of('<g visibility="hidden"><line x2="5" visibility="visible"/></g>') == 5
    body = '<line x2="1"/><g display="none"><line x2="5" style="display:inline"/></g>'
    assert length_of(body) == 1


def test_hairlines_and_dashes_are_cut_and_said() -> None:
    body = '<line x2="5" stroke-width="0"/><line x2="5" stroke-dasharray="1 2"/>'
    assert codes(body) == ["svg-dashed", "svg-hairline"]
    assert length_of(body) == 10


# --- structure ------------------------------------------------------------------------------------


@pytest.mark.parametrize("tag", ["defs", "symbol", "clipPath", "mask", "pattern", "marker", "font"])
def test_what_only_defines_is_not_cut(tag: str) -> None:
    body = f'<{tag}><g><path d="M0 0h50"/></g></{tag}><line x2="5"/>'
    assert length_of(body) == 5
    assert codes(body) == []


def test_glyphs_are_not_cut_and_text_is_said() -> None:
    body = '<font><glyph><path d="M0 0h50"/></glyph></font><line x2="5"/><text>A</text><text/>'
    assert length_of(body) == 5
    reading = read(body)
    assert dict(reading.parts[0].measures.not_cut) == {"text": 2}
    assert [str(d) for d in reading.diagnostics] == [
        "a.svg: warning svg-text: found 2 texts, which no tool follows; convert text to curves to "
        "have it cut"
    ]


def test_images_are_counted_and_clips_are_said() -> None:
    body = '<image/><foreignObject/><line x2="5" clip-path="url(#c)"/><text display="none"/>'
    assert [d.message for d in read(body).diagnostics] == [
        "found 1 foreignObject, 1 image, which no tool follows; expected curves only",
        "found 1 elements that are clipped or masked; their paths are read whole",
    ]
    assert codes("<image/><text>x</text>")[-1] == "drawing-empty"


def test_uses() -> None:
    body = '<defs><g id="p"><line x2="5"/></g></defs><use xlink:href="#p" x="10" y="20"/>'
    body += '<use href="#p" transform="scale(2)" stroke="blue"/>'
    reading = read(body, XLINK)
    first, second = reading.parts[0].contours
    assert first.curves[0].start == pytest.approx((10, 80))
    assert (second.curves[0].length, first.colour) == (10, "#ff0000")
    assert second.colour == "#0000ff"


def test_symbols_have_a_window_of_their_own() -> None:
    body = '<symbol id="s" viewBox="0 0 10 10"><line x2="10" y2="10"/></symbol>'
    body += '<use href="#s" x="50" width="20" height="40"/>'
    (contour,) = read(body).parts[0].contours
    assert contour.curves[0].start == pytest.approx((50, 90))
    assert contour.curves[0].end == pytest.approx((70, 70))


def test_a_use_of_nothing_is_said_and_of_itself_refused() -> None:
    assert codes('<use href="#x"/><use href="a.svg#x"/><line x2="1"/>') == ["svg-use"] * 2
    assert codes('<g id="a"><use href="#a"/></g>') == ["svg-depth"]
    assert codes("<g>" * 250 + "</g>" * 250) == ["svg-depth"]


def test_a_switch_shows_its_first_plain_child() -> None:
    body = '<switch><g requiredExtensions="x"><line x2="9"/></g><g><line x2="5"/></g>'
    assert length_of(body + '<g><line x2="7"/></g></switch>') == 5


def test_an_svg_inside_scales_its_content() -> None:
    body = '<svg x="10" y="10" width="20" height="20" viewBox="0 0 10 10"><line x2="10"/></svg>'
    (contour,) = read(body).parts[0].contours
    assert contour.curves[0].end == pytest.approx((30, 90))


# --- layers ---------------------------------------------------------------------------------------


def test_layers_of_corel_inkscape_and_others() -> None:
    corel = '<g id="Page"><g id="Camada_x0020_1"><metadata id="CorelCorpID_0Corel-Layer"/>'
    assert layers(corel + '<g id="_107"><line x2="1"/></g></g></g>') == ["Camada 1"]
    inkscape = PAGE + ' xmlns:inkscape="urn:i"'
    inner = '<g id="l1" inkscape:groupmode="layer" inkscape:label="Cut"><line x2="1"/></g>'
    assert layers(f'<g id="all">{inner}</g>', inkscape) == ["Cut"]
    assert layers('<g id="Engrave"><g id="b"><line x2="1"/></g></g>') == ["Engrave"]
    assert layers('<g id="_1072143200"><line x2="1"/></g><line x2="1"/>') == [None, None]


def test_layers_can_be_chosen() -> None:
    body = '<g id="Cut"><line x2="1"/></g><g id="Mark"><line x2="10"/></g><line x2="100"/>'
    assert length_of(body, layers=("cut",)) == 1
    assert length_of(body, layers=("Mark", "Cut")) == 11
    (said, _) = read(body, layers=("Cutt", "Cut")).diagnostics
    assert str(said) == (
        "a.svg: error drawing-layer-option: found no layer 'Cutt'; "
        "expected one of the drawing's: 'Cut'"
    )


def test_escaped_names() -> None:
    for escaped, name in (("Layer_x0020_1", "Layer 1"), ("Warstwa_x00B7_a_b", "Warstwa·a_b")):
        assert layer_of(Element("g", {"id": escaped}, 1), 0) == name


def test_contours_know_their_line_and_id() -> None:
    (contour,) = read('<g>\n<line id="k1" x2="5"/></g>').parts[0].contours
    assert str(contour.source) == "a.svg:3:k1"


def test_closed_is_what_ends_where_it_starts() -> None:
    body = '<path d="M0 0h5v5z"/><path d="M0 0h5v5L0 0"/><path d="M0 0h5v5"/><circle r="1"/>'
    assert [(c.closed, c.kind) for c in read(body).parts[0].contours] == [
        (True, "outer"),
        (True, "outer"),
        (False, "open"),
        (True, "outer"),
    ]
