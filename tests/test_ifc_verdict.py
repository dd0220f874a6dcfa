"""`inspect` and `convert` give one verdict on every member of a model."""

import json
from pathlib import Path

from click.testing import CliRunner

from beamcam.cli import main
from tests.property.ifc_cuts import SIZES, Bar, Box, Cuts, Half


def test_inspect_and_convert_say_the_same(tmp_path: Path) -> None:
    made = Cuts()
    beam, tube = Bar("I", 1500.0, SIZES["I"]), Bar("RO", 1200.0, SIZES["RO"])
    for bar, cutters in (
        (beam, [Box((-9.0, 240.0, -9.0), (120.0, 309.0, 159.0))]),  # a cope
        (beam, [Half((0.0, 295.0, 0.0), (0.0, 1.0, 0.0))]),  # a flange planed thinner
        (tube, [Box((-9.0, 164.0, 80.0), (150.0, 180.0, 90.0))]),  # a groove in its wall
    ):
        made.small.element(made.body(bar, cutters), tag=f"B{made.step.count}")
    path = tmp_path / "model.ifc"
    path.write_bytes(made.small.data)
    run = CliRunner()
    shown = run.invoke(main, ["inspect", str(path), "--json"])
    written = run.invoke(main, ["convert", str(path), "-o", f"{tmp_path}/nc/", "--json"])
    assert (shown.exit_code, written.exit_code) == (1, 1)
    seen = {(d["where"], d["severity"], d["code"]) for d in json.loads(shown.stdout)["diagnostics"]}
    wrote = {
        (d["where"], d["severity"], d["code"])
        for d in json.loads(written.stderr)
        if d["code"].startswith("ifc-")
    }
    assert {row for row in seen if row[1] == "error"} == {row for row in wrote if row[1] == "error"}
    assert len({row for row in seen if row[1] == "error"}) == 2
    fast = run.invoke(main, ["inspect", str(path), "--json", "--no-check"])
    assert len(json.loads(fast.stdout)["parts"]) == 2
