"""The machine where none is named."""

from pathlib import Path

import pytest

from beamcam.machine import (
    DEFAULT_MACHINE,
    DEFAULTS,
    default_machines,
    is_of_sheets,
    load,
    shipped,
)
from beamcam.readers import is_of_programs


def test_the_table_is_that_of_the_machine_files() -> None:
    places: dict[tuple[str, str], dict[int, str]] = {}
    for machine in map(load, shipped()):
        for suffix in machine.default_for:
            rows = places.setdefault((machine.stock, suffix), {})
            assert machine.choice not in rows, f"two machines have one place for {suffix}"
            rows[machine.choice] = machine.name
    found = {key: tuple(rows[n] for n in sorted(rows)) for key, rows in places.items()}
    assert found == DEFAULTS


def test_a_machine_of_ones_own_is_no_default(tmp_path: Path) -> None:
    """A file does not take over what its base is the default for, nor is it another program."""
    path = tmp_path / "mine.toml"
    path.write_text('base = "plate-linuxcnc"\n')
    mine, base = load(str(path)), load("plate-linuxcnc")
    assert base.default_for
    assert (mine.default_for, mine.choice) == ((), 1)
    assert mine.checksum == base.checksum


@pytest.mark.parametrize(
    ("stock", "output", "name"),
    [
        ("beam", "a.gcode", "beamline"), ("beam", "a.ngc", "beamline"), ("beam", "", "beamline"),
        ("sheet", "A.NGC", "plate-linuxcnc"), ("sheet", "a.nc", "laser-grbl"),
        ("sheet", "a.gcode", "plate-codesys"), ("sheet", "-", "plate-linuxcnc"),
        ("sheet", "x/a.h", "laser-stepper"), ("sheet", "a.st", "table-simotion"),
    ],
)  # fmt: skip
def test_by_stock_and_suffix(stock: str, output: str, name: str) -> None:
    assert default_machines("sheet" if stock == "sheet" else "beam", output)[0] == name


def test_what_a_suffix_tells() -> None:
    assert DEFAULT_MACHINE == "beamline"
    assert is_of_sheets("a.ngc")
    assert not is_of_sheets("a.gcode")  # which bars have too
    assert is_of_programs("a.gcode")
    assert not is_of_programs("a.nc1")
