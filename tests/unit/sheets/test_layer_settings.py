"""Speed, power, passes and order by colour or layer: planned, refused, and read back."""

from collections.abc import Callable

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.errors import PlanError
from beamcam.machine import load as load_machine
from beamcam.machine.machine import Machine
from beamcam.machine.overlay import with_torch
from beamcam.machine.torch import LayerSettings
from beamcam.model.part import Part
from beamcam.model.request import Request
from beamcam.pipeline import post, read_back
from beamcam.readers import read
from tests.conftest import examples, sampled

GRBL = load_machine("laser-grbl")
TABLES = (
    ("plate-linuxcnc", None), ("laser-stepper", ".steps"), ("laser-stepper", ".csv"),
    ("table-simotion", "chain"),
)  # fmt: skip


def drawing(inner: str = "lime", line: str = "blue") -> Part:
    """A plate with a hole and a line beside it, each of its own colour."""
    text = f"""<svg xmlns="http://www.w3.org/2000/svg" width="100mm" height="80mm"
    viewBox="0 0 100 80"><g fill="none"><rect x="5" y="5" width="90" height="70" stroke="red"/>
    <circle cx="30" cy="40" r="12" stroke="{inner}"/>
    <path d="M50 20 h30 v10" stroke="{line}"/></g></svg>"""
    (part,) = read(text.encode(), "t.svg").parts
    return replace(part, profile=replace(part.profile, web_thickness=3.0))


def asked(machine: Machine = GRBL, **own: LayerSettings) -> Machine:
    meanings = {"red": "cut", "lime": "cut", "blue": "mark"}
    return with_torch(machine, meanings, settings=own)  # type: ignore[arg-type]


def codes(text: str, machine: Machine, part: Part | None = None) -> set[str]:
    said = read_back(text, Request((part or drawing(),), machine))
    return {one.code for one in said}


def crossed(colour: str) -> Part:
    """Thirteen blue lines a millimetre apart, and a line across them."""
    across = "".join(f'<path d="M{20 + k} 10 v50" stroke="blue"/>' for k in range(13))
    text = f"""<svg xmlns="http://www.w3.org/2000/svg" width="100mm" height="80mm"
    viewBox="0 0 100 80"><g fill="none"><rect x="5" y="5" width="90" height="70" stroke="red"/>
    {across}<path d="M20 30 h12" stroke="{colour}"/></g></svg>"""
    (part,) = read(text.encode(), "t.svg").parts
    return replace(part, profile=replace(part.profile, web_thickness=3.0))


def test_a_line_has_its_own_settings_and_not_those_of_lines_that_it_crosses() -> None:
    own = {"blue": LayerSettings(power=500.0), "magenta": LayerSettings(power=120.0)}
    machine = with_torch(GRBL, {"red": "cut", "blue": "mark", "magenta": "mark"}, settings=own)
    right, wrong = (post((crossed(c),), machine).text for c in ("magenta", "blue"))
    assert codes(right, machine, crossed("magenta")) == set()
    assert "verify-sheet-settings" in codes(wrong, machine, crossed("magenta"))


looks = st.builds(
    LayerSettings,
    st.none() | st.sampled_from([240.0, 600.0, 1234.5]),
    st.none() | st.sampled_from([120.0, 500.0, 850.0]),
    st.none() | st.integers(1, 3),
)


@settings(max_examples=examples(25), deadline=None)
@given(red=looks, lime=looks, blue=looks, order=st.sampled_from([(0, 0, 0), (2, 1, 0), (5, 5, 5)]))
def test_what_is_asked_is_what_stands_in_the_program(
    red: LayerSettings, lime: LayerSettings, blue: LayerSettings, order: tuple[int, int, int]
) -> None:
    own = {
        name: replace(look, order=place)
        for name, look, place in zip(("red", "lime", "blue"), (red, lime, blue), order, strict=True)
    }
    starts = post((drawing(),), asked(**own)).text.split("\n")
    starts = [line for line in starts if line.startswith("M4")]
    defaults = {"blue": (120.0, 3000.0), "lime": (900.0, 700.0), "red": (900.0, 700.0)}
    expected = []
    for name, (power, speed) in defaults.items():
        look = own[name]
        power = power if look.power is None else look.power
        speed = speed if look.speed is None else look.speed
        expected += [f"M4 S{power:g} F{speed:g}"] * (look.passes or 1)
    assert starts == expected


LAST_PASS = "G0 X2 Y72\nM4 S950 F600\nG1 X92 Y72\nG1 X92 Y2\nG1 X2 Y2\nG1 X2 Y72\nM5\n"

FAULTS: dict[str, tuple[Callable[[str], str], str]] = {
    "another speed": (lambda t: t.replace("F600", "F700"), "verify-sheet-feed"),
    "another power": (lambda t: t.replace("S950", "S900"), "verify-sheet-settings"),
    "a pass too few": (
        lambda t: t.replace(LAST_PASS, "", 1),
        "verify-sheet-settings",
    ),
    "a pass too many": (
        lambda t: t.replace(LAST_PASS, 2 * LAST_PASS, 1),
        "verify-sheet-settings",
    ),
    "settings exchanged": (
        lambda t: t.replace("S950 F600", "S- F-").replace("S900 F700", "S950 F600")
        .replace("S- F-", "S900 F700"),
        "verify-sheet-settings",
    ),
}  # fmt: skip


@pytest.mark.parametrize("fault", FAULTS)
def test_a_program_with_other_settings_is_refused(fault: str) -> None:
    machine = asked(red=LayerSettings(600.0, 950.0, 2))
    text = post((drawing(),), machine).text
    assert LAST_PASS in text
    assert codes(text, machine) == set()
    change, code = FAULTS[fault]
    assert change(text) != text
    assert code in codes(change(text), machine)


def test_another_order_is_refused_by_the_read_back() -> None:
    machine, other = asked(lime=LayerSettings(order=1), red=LayerSettings(order=2)), asked()
    apart = asked(blue=LayerSettings(order=1), red=LayerSettings(order=1))
    mixed = with_torch(apart, {"lime": "mark"})  # three marks and cuts, lime before blue
    assert codes(post((drawing(),), machine).text, other) == set()
    text = post((drawing(),), mixed).text
    later = with_torch(mixed, {"lime": "mark"}, settings={"lime": LayerSettings(order=1)})
    before = with_torch(later, {"blue": "mark"})
    assert codes(text, mixed) == set()
    assert codes(text, before) == {"verify-sheet-turn"}


def test_an_order_that_would_cut_a_part_free_first_is_refused() -> None:
    for own in ({"lime": LayerSettings(order=1)}, {"blue": LayerSettings(order=1)}):
        with pytest.raises(PlanError) as found:
            post((drawing(),), asked(**own))
        assert [one.code for one in found.value.diagnostics] == ["plan-map-order"]


def test_settings_that_a_machine_cannot_follow_are_refused_by_their_key() -> None:
    stepper = load_machine("laser-stepper")
    with pytest.raises(PlanError) as found:
        post((drawing(),), asked(stepper, red=LayerSettings(600.0, 950.0, 2, 1)))
    said = found.value.diagnostics
    assert {one.code for one in said} == {"plan-map-setting"}
    assert [one.message.split(" = ")[0] for one in said] == ["found map.red.power"]
    plate = load_machine("plate-codesys")
    with pytest.raises(PlanError) as found:
        post((drawing(),), asked(plate, red=LayerSettings(power=950.0)))
    assert "map.red.power = 950" in found.value.diagnostics[0].message


OWN = {"lime": LayerSettings(speed=420.0, order=1), "red": LayerSettings(passes=2, order=2)}
LIES = {
    "a pass too few": {"red": LayerSettings(order=2)},
    "a pass too many": {"red": LayerSettings(passes=3, order=2)},
    "passes of another colour": {
        "red": LayerSettings(order=2), "lime": LayerSettings(speed=420.0, passes=2, order=1),
    },
    "another speed": {"lime": LayerSettings(speed=400.0, order=1)},
    "the speed of its process": {"lime": LayerSettings(order=1)},
    "the speed of another colour": {
        "lime": LayerSettings(order=1), "red": LayerSettings(speed=420.0, passes=2, order=2),
    },
}  # fmt: skip


@pytest.mark.parametrize(("name", "style"), sampled(TABLES, 2))
def test_tables_follow_speed_passes_and_order(name: str, style: str | None) -> None:
    machine = asked(load_machine(name), **OWN)
    text = post((drawing(),), machine, style=style).text

    def said(own: dict[str, LayerSettings]) -> set[str]:
        request = Request((drawing(),), asked(machine, **{**OWN, **own}), style=style)
        return {one.code for one in read_back(text, request)}

    assert said({}) == set()
    for lie, own in LIES.items():
        assert said(own) & {
            "verify-sheet-settings", "verify-sheet-feed", "verify-sheet-twice", "steps-speed",
            "st-speed",
        }, lie  # fmt: skip


def test_contours_of_two_colours_are_not_joined() -> None:
    """Two halves of a ring, each at its own speed."""
    text = b"""<svg xmlns="http://www.w3.org/2000/svg" width="100mm" height="80mm"
    viewBox="0 0 100 80"><g fill="none"><path d="M10 10 h50 v30" stroke="red"/>
    <path d="M60 40 h-50 v-30" stroke="lime"/></g></svg>"""
    (part,) = read(text, "t.svg").parts
    part = replace(part, profile=replace(part.profile, web_thickness=3.0))
    written = post((part,), asked(red=LayerSettings(speed=500.0))).text
    assert written.count("M4 S900 F500") == 1
    assert written.count("M4 S900 F700") == 1


def test_passes_of_a_row_hold_for_its_process() -> None:
    torch = GRBL.torch
    assert torch is not None
    rows = tuple(replace(r, passes=2) if r.process == "cut" else r for r in torch.rows)
    machine = replace(GRBL, torch=replace(torch, rows=rows))
    text = post((drawing(),), asked(machine)).text
    assert text.count("M4 S900 F700") == 4
    assert "verify-sheet-settings" in codes(post((drawing(),), asked()).text, asked(machine))
