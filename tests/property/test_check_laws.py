"""What `batch` wrote, `check` finds to be the same, whatever it was asked for."""

import os
import shutil
from pathlib import Path
from tempfile import TemporaryDirectory

from click.testing import CliRunner
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from beamcam.cli import main
from tests.conftest import SAMPLES, examples
from tests.runs import BAD, part

OWN = 'base = "beamline-annex"\nsuffix = ".annex"\n'
TABLE = 'base = "plate-codesys"\nsuffix = ".tab"\n'
#: Lines of a configuration, of which any may stand in it.
LINES = (
    'job = "NIGHT"', "stock_lengths = [6000, 12000]", 'allow_skips = ["tool"]', "flat = true",
    'name = "{profile}/{mark}_{quantity}{suffix}"', "tolerances.merge = 0.3",
    "sheet.thickness = 3", 'map.ETCH = "ignore"', 'quantity = "file"',
)  # fmt: skip
MACHINES = (
    "", 'machine = "beamline-pusher"', 'machines = { beam = "mine.toml" }',
    'machines = { sheet = "table.toml", beam = "beamline-annex" }',
    'machines = { beam = ["beamline", "mine.toml", "beamline-pusher"] }', 'machine = "hall"',
)  # fmt: skip
OPTIONS = (
    "--bar=9000", "--flat", "--tree", "--job=DAY", "--name={stem}-{number}{suffix}",
    "--machine=beamline", "--machine=shop/mine.toml", "--quantity=2", "--thickness=4",
    "--map=ETCH=mark", "--allow-skips=none", "--no-verify",
)  # fmt: skip


def call(*words: object) -> tuple[int, str]:
    done = CliRunner().invoke(main, [str(word) for word in words])
    assert done.exception is None or isinstance(done.exception, SystemExit), done.exception
    return done.exit_code, done.output


def lay_out(folder: Path, depth: int) -> None:
    """Parts of both kinds of stock in folders of folders, one of them refused, and machines."""
    jobs = folder / "shop" / "jobs"
    (jobs / "A" / "deep").mkdir(parents=True)
    (jobs / "A" / "one.nc1").write_text(part("ONE", quantity=3))
    (jobs / "A" / "deep" / "two.nc1").write_text(part("TWO", 2500.0))
    (jobs / "bad.nc1").write_text(BAD)
    if depth:
        (jobs / "B").mkdir()
        (jobs / "B" / "one.nc1").write_text(part("ONE-B", 1700.0))
        shutil.copy(SAMPLES / "dxf" / "plate.dxf", jobs / "B" / "sheet.dxf")
    (folder / "shop" / "mine.toml").write_text(OWN)
    (folder / "shop" / "table.toml").write_text(TABLE)
    for place in ("shop/jobs", "shop", "apart"):  # known by name beside each configuration
        (folder / place / "machines").mkdir(parents=True)
        (folder / place / "machines" / "hall.toml").write_text('base = "beamline"\n')


#: Nothing of it lies in the folder of the commands.
TRUST = ("--trust=shop", "--trust=apart")


@settings(max_examples=examples(30))
@given(
    depth=st.integers(0, 1),
    lines=st.sets(st.sampled_from(LINES), max_size=4),
    machines=st.sampled_from(MACHINES),
    options=st.sets(st.sampled_from(OPTIONS), max_size=3),
    place=st.sampled_from(["shop/jobs", "shop", "apart"]),
    moved=st.booleans(),
)
@example(1, {LINES[4], LINES[1]}, MACHINES[2], {"--tree"}, "shop", True)
@example(1, set(), MACHINES[3], {"--machine=shop/mine.toml", "--bar=9000"}, "apart", True)
def test_batch_then_check_holds(
    depth: int, lines: set[str], machines: str, options: set[str], place: str, moved: bool
) -> None:
    before = Path.cwd()
    with TemporaryDirectory() as name:
        folder = Path(name, "work")
        folder.mkdir()
        lay_out(folder, depth)
        text = "\n".join([machines, *sorted(lines)])
        if "--bar=9000" in options:
            options = {*options, "--each"}  # over stock, files have no program of their own
        if place == "apart":
            text = text.replace("mine.toml", "../shop/mine.toml")
            text = text.replace("table.toml", "../shop/table.toml")
            options = {*options, "--config=apart/beamcam.toml"}
        elif place == "shop/jobs":
            text = text.replace("mine.toml", "../mine.toml").replace("table.toml", "../table.toml")
        (folder / place / "beamcam.toml").write_text(text + "\n")
        os.chdir(folder)
        try:
            status, said = call(
                "batch", "shop/jobs", "-o", "golden", *sorted(options), "--jobs=1", *TRUST
            )
            assert status in (0, 1), said
            programs = [p for p in Path("golden").rglob("*") if p.is_file() and p.name[0] != "."
                        and not p.name.endswith(".hand.csv")]  # fmt: skip
            assume(programs)  # as of sheet options for a machine without a torch
            if moved:  # all of it, with the folder that it lies in
                os.chdir(name)
                folder.rename(Path(name, "elsewhere"))
                os.chdir(Path(name, "elsewhere"))
            status, said = call("check", "golden", *TRUST)
            assert f"{len(programs)} of {len(programs)} programs are the same" in said
            assert status == 0, said
        finally:
            os.chdir(before)
