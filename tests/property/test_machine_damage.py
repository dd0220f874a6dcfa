"""A machine file with any of its values damaged is a machine, or is refused: never a traceback."""

import copy
from pathlib import Path
from typing import Any

from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from beamcam.arguments import load_machine
from beamcam.errors import BeamcamError, Diagnostic, errors_in
from beamcam.machine.keys import _key, _toml
from beamcam.machine.load import files_of_machine, merged
from beamcam.pipeline import post
from beamcam.readers import read
from tests.conftest import SAMPLES, examples

HALL = str(SAMPLES / "machines" / "hall-drill.toml")
BASES = ("beamline", "beamline-annex", "beamline-pusher", "plate-linuxcnc", "plate-codesys", HALL)
#: What a value may become; None takes its key away.
VALUES = (False, True, 0, -1, 1e9, 0.5, "", "x", [], {}, ["G0 X{x}"], None)
PARTS = {
    stock: read((SAMPLES / "dstv" / name).read_bytes(), name).parts
    for stock, name in (("beam", "strut.nc1"), ("sheet", "gusset.nc1"))
}
Place = tuple[str | int, ...]


def table_of(base: str) -> dict[str, Any]:
    table = copy.deepcopy(merged(files_of_machine(base))[0])
    for key in ("name", "default_for"):
        table.pop(key, None)
    if "drill" in table:  # sixty rows of one kind are one place to damage
        table["drill"]["cutting"] = table["drill"]["cutting"][-6:]
    return table


def places(table: Any, above: Place = ()) -> list[Place]:
    """Where something stands in a table, the tables in it included."""
    rows = table.items() if isinstance(table, dict) else enumerate(table)
    found: list[Place] = []
    for key, value in rows:
        found.append((*above, key))
        if isinstance(value, dict | list):
            found += places(value, (*above, key))
    return found


TABLES = {base: table_of(base) for base in BASES}
PLACES = {base: places(table) for base, table in TABLES.items()}


def outcome(path: Path) -> tuple[bool, tuple[Diagnostic, ...]]:
    """Whether a machine posts its part, and what is said; any other error is a fault of ours."""
    try:
        machine = load_machine(str(path))
        return True, post(PARTS[machine.stock], machine).remarks
    except BeamcamError as error:
        return False, error.diagnostics


@settings(
    max_examples=examples(40),
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
@given(
    case=st.sampled_from(BASES).flatmap(
        lambda base: st.tuples(st.just(base), st.sampled_from(PLACES[base]))
    ),
    value=st.sampled_from(VALUES),
)
@example(("beamline-pusher", ("spindles", 1, "across", "position")), 3)
@example(("beamline", ("saw",)), None)
@example(("beamline", ("drill",)), None)
@example(("beamline", ("controller",)), "linuxcnc")
@example(("beamline", ("spindles",)), [])
def test_damage_is_told(tmp_path: Path, case: tuple[str, Place], value: object) -> None:
    base, place = case
    table = copy.deepcopy(TABLES[base])
    at: Any = table
    for key in place[:-1]:
        at = at[key]
    if value is None:
        del at[place[-1]]
    else:
        at[place[-1]] = value
    path = tmp_path / "m.toml"
    path.write_text("".join(f"{_key(k)} = {_toml(v)}\n" for k, v in table.items()))
    is_posted, said = outcome(path)
    assert is_posted != bool(errors_in(said))
