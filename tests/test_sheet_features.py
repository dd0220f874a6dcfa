"""Cells of the table "What each machine can" of docs/lasers.md: made and read back, or refused.

Strokes are counted by readers of our own, one for each kind of program.
"""

import re
from functools import cache
from pathlib import Path

import pytest
from msgspec import Struct, field
from msgspec.structs import replace

from beamcam.errors import PlanError
from beamcam.machine import Machine, load
from beamcam.machine.overlay import with_torch
from beamcam.machine.tables import DIALECTS
from beamcam.machine.torch import LayerSettings
from beamcam.model.request import Request
from beamcam.pipeline import post, read_back
from tests.conftest import sampled
from tests.unit.sheets.parts import box, circle, contour, drawing

PAGE = Path(__file__).parent.parent / "docs" / "lasers.md"
PART = drawing(
    contour(box(10, 10, 50, 40), line=1),
    contour(circle(22, 22, 12), "#00ff00", line=2),
    contour(circle(50, 40, 12), "#ff00ff", line=3),
    contour(box(34, 14, 9, 6), "#0000ff", line=4),
    thickness=3.0,
)
MEANINGS = {"red": "cut", "lime": "cut", "magenta": "cut", "blue": "mark"}
HATCH = LayerSettings(hatch=2.0)


class Feature(Struct, frozen=True):
    """What is asked for, and how many strokes the program has more by it."""

    values: dict[str, object] = field(default_factory=dict)
    own: dict[str, LayerSettings] = field(default_factory=dict)
    more: int = 0
    is_free: bool = False  #: whether a program may have it though nobody asks for it


FEATURES = {
    "speed": Feature(own={"lime": LayerSettings(speed=150.0)}),
    "power": Feature(own={"lime": LayerSettings(power=333.0)}),
    "passes": Feature(own={"lime": LayerSettings(passes=3)}, more=2),
    "order": Feature(
        own={"magenta": LayerSettings(order=1), "red": LayerSettings(order=2)}, is_free=True
    ),
    "hatch, both ways": Feature(own={"blue": HATCH}, more=3),
    "hatch_angle": Feature(own={"blue": replace(HATCH, hatch_angle=90.0)}, more=4),
    "hatch_one_way": Feature(own={"blue": replace(HATCH, hatch_one_way=True)}, more=3),
    "hatch_outline = false": Feature(own={"blue": replace(HATCH, hatch_outline=False)}, more=2),
    "--overcut": Feature({"overcut": 1.5}),
    "overcut of a colour": Feature(own={"lime": LayerSettings(overcut=1.5)}),
    "--tabs": Feature({"tabs": 2}, more=2),
    "--inner-tabs": Feature({"tabs": 1, "inner_tabs": True}, more=3),
    "--mirror": Feature({"mirror": "x"}),
    "--rotate": Feature({"rotate": 30.0}),
    "--copies": Feature({"copies": (2, 1)}, more=4),
    "--origin": Feature({"origin": "centre"}),
    "--kerf, --lead": Feature(
        {"kerf": 0.4, "kerf_by": "offset", "lead": "line", "lead_in": 2.0, "lead_out": 1.0}
    ),
}  # fmt: skip


def rows_of_page() -> list[tuple[str, dict[str, str]]]:
    """The rows of the table: the feature, and what is said of each machine."""
    text = PAGE.read_text(encoding="utf-8").split("## What each machine can\n")[1].split("\n## ")[0]
    head, _, *rows = [
        [cell.strip() for cell in line.strip("|").split("|")]
        for line in text.splitlines() if line.startswith("|")
    ]  # fmt: skip
    machines = [name.strip("`") for name in head[1:]]
    return [(row[0].replace("`", ""), dict(zip(machines, row[1:], strict=True))) for row in rows]


TABLE = rows_of_page()
CELLS = [(feature, name, said) for feature, row in TABLE for name, said in row.items()]


def asked(name: str, feature: Feature) -> Machine:
    values = {
        "place": "corner", "margin": 5.0, "lead": "none", "kerf_by": "none", **feature.values
    }  # fmt: skip
    return with_torch(load(name), MEANINGS, settings=feature.own, **values)  # type: ignore[arg-type]


@cache
def plain(name: str, style: str | None) -> str:
    return post((PART,), asked(name, Feature()), style=style).text


def strokes(text: str, machine: Machine) -> int:
    """How often a program starts its tool."""
    if machine.controller in DIALECTS:
        return len(re.findall(r"kind := USINT#[135],", text))
    if machine.controller == "stepper":
        rows = [row.split(",") for row in re.findall(r"^-?\d.*", text, re.M)]
        laser = "0" + "".join(row[3 if len(row) == 4 else 4] for row in rows)
        return laser.count("01")
    return len(re.findall(r"^(?:N\d+ )?(?:M0?[347]\b|M13\b)", text, re.M))


def test_the_table_has_every_feature_and_every_machine_of_sheets() -> None:
    from beamcam.machine.load import shipped

    machines = {name for name in shipped() if load(name).torch is not None}
    assert [feature for feature, _ in TABLE] == list(FEATURES)
    assert all(set(row) == machines for _, row in TABLE)


@pytest.mark.parametrize(("feature", "name", "cell"), sampled(CELLS, 7))
def test_a_cell_is_as_the_page_says(feature: str, name: str, cell: str) -> None:
    wanted = FEATURES[feature]
    if cell != "yes":
        refused = re.fullmatch(r"no: `(.*)`", cell)
        assert refused, cell
        with pytest.raises((PlanError, ValueError), match=refused[1]) as found:
            post((PART,), asked(name, wanted))
        key = feature.strip("-")
        assert re.search(rf"\b{key}\b", str(found.value))
        return
    machine = asked(name, wanted)
    style = None
    if machine.controller == "stepper":
        # Of velocities a pass that begins where one ends has no row between.
        style = ".steps" if feature == "passes" else ".csv"
    text, without = post((PART,), machine, style=style).text, plain(name, style)

    def is_refused(text: str, machine: Machine) -> bool:
        return bool(read_back(text, Request((PART,), machine, style=style)))

    assert strokes(text, machine) - strokes(without, machine) == wanted.more
    assert not is_refused(text, machine)
    assert is_refused(text, asked(name, Feature())) != wanted.is_free
    assert is_refused(without, machine)
