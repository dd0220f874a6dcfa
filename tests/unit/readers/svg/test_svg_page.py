"""How long a unit of an SVG is: 100.000 mm for a square of 100 mm, or a refusal."""

import pytest

from tests.svg_text import box_of, codes, read

IN = 100 / 25.4
SQUARE = '<rect width="{0}" height="{0}"/>'
ILLUSTRATOR = "<!-- Generator: Adobe Illustrator 16.0.0, SVG Export -->"
COREL = "<!-- Creator: CorelDRAW X6 -->"
INKSCAPE = 'xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" inkscape:version="{}"'


def sizes(number: float, unit: str, box: float) -> str:
    return f'width="{number!r}{unit}" height="{number!r}{unit}" viewBox="0 0 {box!r} {box!r}"'


@pytest.mark.parametrize(
    ("head", "side"),
    [
        (sizes(100, "mm", 100), 100),
        (sizes(100, "mm", 10000), 10000),
        (sizes(10, "cm", 100), 100),
        (sizes(100, "mm", 83.13), 83.13),
        (sizes(IN, "in", 1000), 1000),
        (sizes(IN, "in", 55002), 55002),
        (sizes(IN * 72, "pt", 100), 100),
        (sizes(IN * 6, "pc", 100), 100),
        (sizes(400, "Q", 7), 7),
        (' width=" 100 mm " height="100MM" viewBox="0,0,100,100"', 100),
        ('width="100mm" viewBox="0 0 100 100"', 100),
        ('height="10cm" viewBox="0 0 100 100"', 100),
        ('style="width:100mm;height:100mm" viewBox="0 0 50 50"', 50),
    ],
)
def test_physical_sizes(head: str, side: float) -> None:
    assert codes(SQUARE.format(side), head) == []
    assert box_of(SQUARE.format(side), head) == pytest.approx((0, 0, 100, 100), abs=1e-9)


@pytest.mark.parametrize(
    ("head", "body", "side"),
    [
        (sizes(IN * 72, "px", 100), ILLUSTRATOR, 100),
        (sizes(IN * 72, "", IN * 72), ILLUSTRATOR, IN * 72),
        (f'width="{IN * 90}" height="{IN * 90}" ' + INKSCAPE.format("0.48.4"), "", IN * 90),
        (f'width="{IN * 96}" height="{IN * 96}" ' + INKSCAPE.format("0.92.1"), "", IN * 96),
        (sizes(IN * 96, "px", 100) + " " + INKSCAPE.format("1.3"), "", 100),
        (sizes(IN * 96, "px", 100), COREL, 100),
        (sizes(IN * 96, "px", 100) + " " + INKSCAPE.format("0.48"), COREL, 100),
        (sizes(IN * 96, "px", 5), '<metadata id="CorelCorpID_0Corel-Layer"/>', 5),
    ],
)
def test_pixels_of_known_writers(head: str, body: str, side: float) -> None:
    assert codes(body + SQUARE.format(side), head) == ["svg-px-writer"]
    assert box_of(body + SQUARE.format(side), head) == pytest.approx((0, 0, 100, 100), abs=1e-9)


def test_the_message_names_the_writer() -> None:
    (said,) = read(COREL + SQUARE.format(100), sizes(378, "px", 100)).diagnostics
    assert str(said) == (
        "a.svg:1: warning svg-px-writer: found a drawing in px (378px); 96 px an inch, as "
        "CorelDRAW writes it; --units px96, px90 or px72 says another"
    )


REFUSED = [
    ("svg-px", sizes(IN * 96, "px", 100)),
    ("svg-px", sizes(IN * 90, "", 100)),
    ("svg-px", 'width="378" height="378"'),
    ("svg-px", 'width="100mm" height="100mm"'),
    ("svg-percent", 'width="100%" height="100%" viewBox="0 0 100 100"'),
    ("svg-percent", 'width="100mm" height="100%" viewBox="0 0 100 100"'),
    ("svg-no-size", 'viewBox="0 0 100 100"'),
    ("svg-no-size", ""),
    ("svg-size-contradict", 'width="100mm" height="100in" viewBox="0 0 100 100"'),
    ("svg-size-contradict", 'width="200mm" height="100mm" viewBox="0 0 100 100"'),
    ("svg-size-contradict", 'width="200px" height="100px" viewBox="0 0 100 100"'),
    ("svg-size", 'width="100mm" height="378px" viewBox="0 0 100 100"'),
    ("svg-size", 'width="wide" height="100mm" viewBox="0 0 100 100"'),
    ("svg-size", 'width="10em" height="10em" viewBox="0 0 100 100"'),
    ("svg-size", 'width="0mm" height="0mm" viewBox="0 0 100 100"'),
    ("svg-size", 'width="-5mm" height="5mm" viewBox="0 0 100 100"'),
    ("svg-size", 'width="5mm" height="5mm" viewBox="0 0 100"'),
    ("svg-size", 'width="5mm" height="5mm" viewBox="0 0 0 100"'),
    ("svg-size", 'width="5mm" height="5mm" viewBox="a b c d"'),
    ("svg-size", 'width="5mm" height="5mm" viewBox="0 0 nan 5"'),
    ("svg-size", 'width="5mm" height="5mm" viewBox="0 nan 5 5"'),
]


@pytest.mark.parametrize(("code", "head"), REFUSED)
def test_what_is_no_size_is_refused(code: str, head: str) -> None:
    reading = read(SQUARE.format(100), head)
    assert [d.code for d in reading.diagnostics] == [code]
    assert reading.parts == ()


def test_the_words_of_a_refusal() -> None:
    def said(head: str) -> str:
        return str(read(SQUARE.format(100), head).diagnostics[0])

    assert said('width="100%" height="100%" viewBox="0 0 9 9"') == (
        "a.svg:1: error svg-percent: found the size '100%', which is no length, expected mm or "
        "inches: give --width or export with a size"
    )
    assert said('width="100mm" height="100in" viewBox="0 0 100 100"') == (
        "a.svg:1: error svg-size-contradict: found 1 mm for a unit by width and viewBox and 25.4 "
        "mm by height and viewBox, expected one scale: give --units or --width"
    )
    assert "nothing that says how many make an inch; expected --units px96" in said('width="5"')


@pytest.mark.parametrize("head", [h for c, h in REFUSED if c != "svg-size" and "viewBox" in h])
def test_a_width_from_the_user_settles_it(head: str) -> None:
    for width in ("100mm", "10cm", 100, 100.0, "100"):
        box = box_of(SQUARE.format(100), head, width=width)
        assert box == pytest.approx((0, 0, 100, 100), abs=1e-9)
        assert codes(SQUARE.format(100), head, width=width) == []


@pytest.mark.parametrize(
    ("units", "head", "side"),
    [
        ("mm", 'width="100%" height="100%" viewBox="0 0 100 100"', 100),
        ("cm", 'viewBox="0 0 10 10"', 10),
        ("in", "", IN),
        ("px90", f'width="{IN * 90}" height="{IN * 90}"', IN * 90),
        ("px72", sizes(IN * 72, "px", 100), 100),
        ("px96", f'height="{IN * 96}" viewBox="0 0 50 50"', 50),
        ("px72", sizes(100, "mm", 100), 100),  # the file does not use px
        ("mm", sizes(IN * 96, "px", 100), 100),
        ("px72", 'width="100mm" height="100mm"', IN * 72),
    ],
)
def test_units_from_the_user(units: str, head: str, side: float) -> None:
    assert codes(SQUARE.format(side), head, units=units) == []
    _, _, right, high = box_of(SQUARE.format(side), head, units=units)
    x0, y0, _, _ = box_of(SQUARE.format(side), head, units=units)
    assert (right - x0, high - y0) == pytest.approx((100, 100), abs=1e-9)


@pytest.mark.parametrize("options", [{"units": "ell"}, {"width": "wide"}, {"width": 0}])
def test_bad_options(options: dict[str, object]) -> None:
    (said,) = read(SQUARE.format(1), **options).diagnostics
    assert said.code in ("drawing-units-option", "drawing-width-option")
    assert read(SQUARE.format(1), **options).refused


def test_rounded_view_boxes_scale_by_the_smaller_side_about_the_middle() -> None:
    head = 'width="100mm" height="100.1mm" viewBox="0 0 1000 1000"'
    box = box_of(SQUARE.format(1000), head)
    assert box == pytest.approx((0, 0.05, 100, 100.05), abs=1e-9)


@pytest.mark.parametrize(
    ("aspect", "low"), [("xMidYMin meet", 0.1), ("xMinYMax", 0.0), ("xMidYMid", 0.05)]
)
def test_a_drawing_stands_where_the_page_says(aspect: str, low: float) -> None:
    head = 'width="100mm" height="100.1mm" viewBox="0 0 1000 1000" '
    box = box_of(SQUARE.format(1000), head + f'preserveAspectRatio="{aspect}"')
    assert box[1] == pytest.approx(low, abs=1e-9)


#: What each value makes of a square of 100 on a page of 200 x 100 mm, y up: box of the square.
FITS = [
    ("xMinYMid meet", (0, 0, 100, 100)), ("xMidYMid", (50, 0, 150, 100)),
    ("xMaxYMin meet", (100, 0, 200, 100)), ("defer xMaxYMax", (100, 0, 200, 100)),
    ("xMidYMin slice", (0, -100, 200, 100)), ("xMinYMid slice", (0, -50, 200, 150)),
    ("xMaxYMax slice", (0, 0, 200, 200)), ("none", (0, 0, 200, 100)),
]  # fmt: skip


@pytest.mark.parametrize(("aspect", "box"), FITS)
@pytest.mark.parametrize("unit", ["mm", ""])
def test_the_page_says_how_a_drawing_lies_in_it(
    aspect: str, box: tuple[float, ...], unit: str
) -> None:
    """With it a page of other proportions than its viewBox contradicts nothing."""
    size = (200, 100) if unit else (200 * 96 / 25.4, 100 * 96 / 25.4)
    head = f'width="{size[0]}{unit}" height="{size[1]}{unit}" viewBox="0 0 100 100" '
    made_by = "<!-- Creator: CorelDRAW X6 -->"
    found = box_of(made_by + SQUARE.format(100), head + f'preserveAspectRatio="{aspect}"')
    assert found == pytest.approx(box, abs=1e-9)


@pytest.mark.parametrize(("aspect", "box"), FITS)
@pytest.mark.parametrize("form", ["svg", "symbol"])
def test_what_lies_inside_says_it_too(aspect: str, box: tuple[float, ...], form: str) -> None:
    kept = f'viewBox="0 0 100 100" preserveAspectRatio="{aspect}"'
    square, size = SQUARE.format(100), 'width="200" height="100"'
    body = (
        f"<svg {size} {kept}>{square}</svg>"
        if form == "svg"
        else f'<defs><symbol id="s" {kept}>{square}</symbol></defs><use href="#s" {size}/>'
    )
    x0, y0, x1, y1 = box
    expected = x0, y0 + 100, x1, y1 + 100  # the upper half of the page
    assert box_of(body, sizes(200, "mm", 200)) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("aspect", ["", "xMid", "xMidYMid meat", "stretch"])
def test_what_says_nothing_leaves_the_contradiction(aspect: str) -> None:
    head = 'width="200mm" height="100mm" viewBox="0 0 100 100" '
    reading = read(SQUARE.format(100), head + f'preserveAspectRatio="{aspect}"')
    assert [d.code for d in reading.diagnostics] == ["svg-size-contradict"]


def test_a_stretched_page_has_two_scales() -> None:
    head = 'width="100mm" height="50mm" viewBox="0 0 100 100" preserveAspectRatio="none"'
    assert box_of(SQUARE.format(100), head) == pytest.approx((0, 0, 100, 50))


def test_y_turns_up_about_the_page_and_nothing_is_cropped() -> None:
    head = 'width="210mm" height="297mm" viewBox="-10 -10 2100 2970"'
    body = '<path d="M-10 -10 L 90 -10 L -10 190"/><path d="M-265 2700 h530 v540 z"/>'
    assert box_of(body, head) == pytest.approx((-25.5, -28, 27.5, 297))
    assert curves_start(body, head) == pytest.approx((0, 297))


def curves_start(body: str, head: str) -> tuple[float, float]:
    return read(body, head).parts[0].features[0].curves[0].start


def test_place_attributes_of_the_root_do_nothing() -> None:
    head = sizes(100, "mm", 100) + ' x="50" y="70"'
    assert box_of(SQUARE.format(100), head) == (0, 0, 100, 100)


def test_the_grid_of_the_numbers_is_told() -> None:
    def grid(path: str, head: str) -> float | None:
        return read(path, head).parts[0].measures.grid

    assert grid('<path d="M0 0l5 5"/>', sizes(1, "in", 1000)) == pytest.approx(0.0254)
    assert grid('<path d="M0 0l5 5.25"/>', sizes(1, "in", 1000)) == pytest.approx(0.000254)
    assert grid('<circle r="1.5"/>', sizes(100, "mm", 100)) == pytest.approx(0.1)
