"""What the words of a machine may say of parts, tools and the job: each placeholder, everywhere.

In the head and at each stroke and cut of a bar, at each contour of a sheet and of a laser.
"""

import re
from datetime import date
from pathlib import Path

import pytest

from beamcam.errors import MachineError, errors_in
from beamcam.machine import load
from beamcam.machine.machine import Machine
from beamcam.machine.words import PART_NAMES, WORK_WORDS
from beamcam.model.description import PART_DATA
from beamcam.model.request import Request
from beamcam.pipeline import read_back
from beamcam.planning.order import tool_loads
from beamcam.readers import read
from tests.conftest import SAMPLES
from tests.runs import call
from tests.unit.planning.shop import hole, part

BEAM, MARKED = str(SAMPLES / "dstv" / "beam.nc1"), str(SAMPLES / "dstv" / "marked.nc1")
GUSSET = str(SAMPLES / "dstv" / "gusset.nc1")
#: Of the samples, as their files say it; the star of a plate is no sign for a comment.
KNOWN = {
    "B1": {"mark": "B1", "name": "beam", "profile": "IPE300", "grade": "S355J2", "length": "4200",
           "quantity": "1", "order": "DEMO", "drawing": "1", "phase": "1"},
    "B-12": {"mark": "B-12", "name": "marked", "profile": "IPE300", "grade": "S355J2",
             "length": "2400", "quantity": "2", "order": "DEMO", "drawing": "7", "phase": "1"},
    "G1": {"mark": "G1", "name": "gusset", "profile": "PL6_180", "grade": "S355J2", "length": "260",
           "quantity": "1", "order": "DEMO", "drawing": "2", "phase": "1"},
}  # fmt: skip


def machine_saying(folder: Path, base: str, more: str = "", station: str = "") -> str:
    """A machine whose head and work say all of a part in comments, and what else is asked."""
    own = load(base).words
    lines = []
    for name in ("header", *WORK_WORDS):
        template = list(getattr(own, name))
        if not template:
            continue
        at = 1 if name == "header" else 0
        of_tool = more if "{diameter}" in " ".join(template) else ""
        template[at:at] = [f"(AT {name} {each}={{{each}}})" for each in PART_DATA]
        template[at:at] = [of_tool] if of_tool else []
        if station:
            template = [row + station if "{diameter}" in row else row for row in template]
        lines.append(f"{name} = {template!r}")
    path = folder / "saying.toml"
    path.write_text(f'base = "{base}"\n[words]\n' + "\n".join(lines) + "\n", encoding="utf-8")
    return str(path)


def said(program: str) -> list[tuple[str, dict[str, str]]]:
    """What each template says of the part, with the template's name; a comment says one value."""
    found: list[tuple[str, dict[str, str]]] = []
    for template, name, value in re.findall(r"^\(AT (\w+) (\w+)=(.*)\)$", program, re.MULTILINE):
        if name == next(iter(PART_DATA)):
            found.append((template, {}))
        assert found[-1][0] == template
        found[-1][1][name] = value
    return found


@pytest.mark.parametrize("name", sorted(PART_NAMES))
def test_every_name_stands_in_the_head_and_at_every_stroke_of_a_bar(
    name: str, tmp_path: Path
) -> None:
    machine, out = machine_saying(tmp_path, "beamline"), tmp_path / "a.gcode"
    call("post", BEAM, MARKED, "--machine", machine, "--date", "2024-02-29", "-o", out, status=0)
    rows = said(out.read_text(encoding="ascii"))
    first, second = ({**KNOWN[mark], "date": "2024-02-29"}[name] for mark in ("B1", "B-12"))
    assert rows[0] == ("header", rows[0][1])
    assert rows[0][1][name] == (first if first == second else f"{first}+{second}")
    work = {template for template, _ in rows[1:]}
    assert work == {"saw", "drill"}
    assert {row[name] for _, row in rows[1:]} == {first, second}
    marks = [row["mark"] for _, row in rows[1:]]
    assert (marks.count("B1"), marks.count("B-12")) == (15, 4)  # 13 strokes and 2 cuts; 3 and 1


@pytest.mark.parametrize("base", ["plate-linuxcnc", "plate-codesys", "laser-grbl"])
def test_sheets_and_lasers_say_them_too(base: str, tmp_path: Path) -> None:
    machine, out = machine_saying(tmp_path, base), tmp_path / "a.ngc"
    text = Path(GUSSET).read_text("ascii")
    if base == "laser-grbl":  # which cuts no steel
        text = text.replace("S355J2", "acrylic").replace("        6.00\n", "        3.00\n")
    (tmp_path / "gusset.nc1").write_text(text, "ascii")
    words = ("--machine", machine, "--date", "2024-02-29", "--allow-skips", "all", "-o", out)
    call("post", tmp_path / "gusset.nc1", *words, status=0)
    rows = said(out.read_text(encoding="ascii"))
    assert {"header", "cut_on", "cut_off"} <= {template for template, _ in rows}
    grade = {"grade": "acrylic"} if base == "laser-grbl" else {}
    assert all(row == {**KNOWN["G1"], **grade, "date": "2024-02-29"} for _, row in rows)


def test_on_a_table_they_stand_in_comments_only(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(
        'base = "plate-linuxcnc"\n[words]\ncut_off = ["M5 $0 ({mark})", "M9 P{mark}"]\n'
    )
    with pytest.raises(MachineError, match="it in a comment"):
        load(str(path))


def test_each_part_of_a_shared_sheet_is_named_where_it_is_cut(tmp_path: Path) -> None:
    machine, out = machine_saying(tmp_path, "plate-linuxcnc"), tmp_path / "a.ngc"
    other = tmp_path / "other.nc1"
    other.write_text(Path(GUSSET).read_text("ascii").replace("  G1\n", "  G2\n", 1), "ascii")
    call("post", GUSSET, other, "--sheet", "1000x500", "--machine", machine, "-o", out, status=0)
    (_, head), *rows = said(out.read_text(encoding="ascii"))
    assert (head["mark"], head["name"], head["date"]) == ("G1+G2", "gusset+other", "")
    counts = [sum(row["mark"] == mark for _, row in rows) for mark in ("G1", "G2")]
    assert counts[0] == counts[1] > 0
    assert {(row["mark"], row["name"]) for _, row in rows} == {("G1", "gusset"), ("G2", "other")}


def test_a_date_is_said_only_if_it_is_asked_for(tmp_path: Path) -> None:
    machine, out = machine_saying(tmp_path, "beamline"), tmp_path / "a.gcode"

    def dates(*words: str) -> set[str]:
        assert call("post", BEAM, "--machine", machine, "-o", out, *words).exit_code == 0
        return {row["date"] for _, row in said(out.read_text(encoding="ascii"))}

    assert dates() == {""}
    assert dates("--date", "2024-02-29") == {"2024-02-29"}
    days = {date.today().isoformat()}
    found = dates("--date", "today")
    assert found in (days, {date.today().isoformat()})
    assert call("post", BEAM, "-o", out, "--date", "tomorrow").exit_code == 2
    folder = tmp_path / "programs"
    words = ("batch", BEAM, "--machine", machine, "--date", "2024-02-29", "-o", folder)
    assert call(*words).exit_code == 0
    assert "date=2024-02-29" in (folder / "beam.gcode").read_text("ascii")
    assert call("check", folder, "--trust", tmp_path).exit_code == 0


def stations(program: str) -> list[tuple[str, int, int]]:
    """Tool, spindle and station of each stroke: by its comment, and by its word."""
    names = re.findall(r"TOOL=(.*?)\)", program)
    chosen = re.findall(r"M40 K(\d+) L[\d.]+ T(\d+)", program)
    return [(name, int(k), int(t)) for name, (k, t) in zip(names, chosen, strict=True)]


def one_with_many_tools() -> str:
    holes = "".join(
        f"  v {x:8.2f}u  150.00  {d:6.2f}\n"
        for x, d in zip(range(200, 1700, 100), (14, 16, 18, 20, 22, 24, 26) * 2, strict=False)
    )
    text = Path(BEAM).read_text("ascii")
    return text[: text.index("BO\n")] + "BO\n" + holes + "EN\n"


def saying_stations(folder: Path) -> Machine:
    return load(machine_saying(folder, "beamline", "(TOOL={tool_name})", " T{station}"))


def test_name_and_station_of_the_tool_are_said_at_every_stroke(tmp_path: Path) -> None:
    """The stations are those that the setup sheet has the operator load and change."""
    from beamcam.pipeline import post

    machine = saying_stations(tmp_path)
    (one,) = read(one_with_many_tools().encode(), "many.nc1").parts
    posted = post([one], machine)
    found = stations(posted.text)
    strokes = [op for op in posted.plan.operations if hasattr(op, "tool")]
    assert [name for name, _, _ in found] == [op.tool.name for op in strokes]
    assert len({name for name, _, _ in found}) == 7  # more than the spindle has stations
    held: dict[int, str] = {}
    loads = list(tool_loads(posted.plan.operations, machine))
    for load_ in (load_ for load_ in loads if load_.out is None):
        held[load_.station] = load_.tool.name
    changes = {load_.before: load_ for load_ in loads if load_.out is not None}
    drilled = (k for k, op in enumerate(posted.plan.operations) if hasattr(op, "tool"))
    for index, (name, _, station) in zip(drilled, found, strict=True):
        if index in changes:
            held[changes[index].station] = changes[index].tool.name
        assert held[station] == name


@pytest.mark.parametrize("wrong", ["T3", "T9", "T0"])
def test_a_station_that_holds_another_tool_is_refused(wrong: str, tmp_path: Path) -> None:
    machine = saying_stations(tmp_path)
    one = part(hole(300), hole(400, 150, 22.0), hole(500, 150, 14.0), hole(600))
    from beamcam.pipeline import post

    program = post([one], machine).text
    assert not errors_in(read_back(program, Request((one,), machine)))
    last = program.rindex("L18 T1")
    changed = program[:last] + f"L18 {wrong}" + program[last + 6 :]
    found = errors_in(read_back(changed, Request((one,), machine)))
    assert any("a drill 18 in station" in said.message for said in found)
