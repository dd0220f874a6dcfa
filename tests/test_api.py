"""The Python API: what it gives, what it raises, and that importing it costs nothing."""

import subprocess
import sys
from pathlib import Path

import pytest

import beamcam
from beamcam import api
from beamcam.errors import MachineError, PlanError, ReadError
from beamcam.machine import load
from tests.conftest import ROOT, SAMPLES
from tests.runs import BAD, part

CHANNEL = SAMPLES / "dstv" / "channel.nc1"


def test_read_plan_post_verify() -> None:
    reading = beamcam.read(CHANNEL)
    assert reading.format == "dstv"
    (channel,) = reading.parts
    plan = beamcam.plan(channel, bar=6000.0)
    assert plan.bar.length == 6000.0
    posted = beamcam.post(reading.parts, "beamline", job="J1", bar=6000.0)
    assert posted.text.startswith("% J1\n")
    assert posted.plan == plan
    assert beamcam.verify(posted.text, channel) == ()
    wrong = posted.text.replace("L18", "L22", 1)
    assert [d.code for d in beamcam.verify(wrong, channel, load("beamline"), name="j.gcode")] != []
    assert beamcam.verify(wrong, channel, name="j.gcode")[0].source.file == "j.gcode"


def test_machines_by_name_path_and_record(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text('base = "beamline"\n')
    parts = beamcam.read(CHANNEL).parts
    texts = {beamcam.post(parts, m).text for m in ("beamline", path, str(path), load("beamline"))}
    assert len(texts) == 1


def test_bytes_are_read_too() -> None:
    reading = beamcam.read(part("A").encode(), name="a.nc1")
    assert reading.parts[0].source.file == "a.nc1"
    assert beamcam.read(CHANNEL.read_bytes()).parts[0].mark == beamcam.read(CHANNEL).parts[0].mark


def test_errors_are_raised(tmp_path: Path) -> None:
    with pytest.raises(ReadError, match="read-file"):
        beamcam.read(tmp_path / "none.nc1")
    with pytest.raises(ReadError, match="read-empty"):
        beamcam.read(b"")
    bad = beamcam.read(BAD.encode(), name="bad.nc1").parts
    with pytest.raises(PlanError, match=r"bad\.nc1:28: error plan-tool"):
        beamcam.post(bad)
    assert "M40" not in beamcam.post(bad, skips=("tool",)).text
    with pytest.raises(MachineError, match="machine-unknown"):
        beamcam.plan(bad, "beamlime")


def test_strict_makes_warnings_errors() -> None:
    data = part("A").replace("  v  100.00u   60.00", "  v  100.00u  600.00").encode()
    assert [d.severity.value for d in beamcam.read(data, name="a.nc1").diagnostics] == ["warning"]
    with pytest.raises(ReadError, match="error dstv-hole-outside"):
        beamcam.read(data, name="a.nc1", strict=True)


def test_no_read_back_is_said() -> None:
    parts = beamcam.read(CHANNEL).parts
    assert beamcam.post(parts, read_back=False).text != beamcam.post(parts).text


ORDERS = (
    "import beamcam; f = beamcam.verify",
    "import beamcam.pipeline, beamcam; f = beamcam.verify",
    "import beamcam.verify; f = beamcam.verify",
    "from beamcam import verify as f",
    "import beamcam; beamcam.read; f = beamcam.verify",
    "import beamcam.verify as f; from beamcam.verify import interpret",
    "from beamcam.api import verify as f",
)


@pytest.mark.parametrize("order", ORDERS)
def test_verify_is_a_function_whatever_was_imported_before(order: str) -> None:
    code = (
        f"{order}\nimport beamcam\n"
        f"parts = beamcam.read({str(CHANNEL)!r}).parts\n"
        "assert f(beamcam.post(parts).text, parts, 'beamline') == ()\n"
        "from beamcam.verify import run, verify\nassert callable(run) and callable(verify)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_importing_it_costs_nothing() -> None:
    code = (
        "import sys; before = set(sys.modules); import beamcam\n"
        "print(sorted(m for m in set(sys.modules) - before if m.startswith('beamcam')))\n"
        "import beamcam.api\n"
        "print([m for m in ('numpy', 'ezdxf', 'ifcopenshell', 'shapely') if m in sys.modules])\n"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True)
    assert done.stdout == "['beamcam']\n[]\n", done.stderr


def test_names() -> None:
    assert set(api.__all__) <= set(dir(beamcam))
    assert (ROOT / "beamcam" / "py.typed").exists()
    with pytest.raises(AttributeError, match="has no attribute 'nothing'"):
        beamcam.nothing  # type: ignore[attr-defined]  # noqa: B018


def test_it_is_typed(tmp_path: Path) -> None:
    """A caller's mistakes are found by mypy, and the example of the documentation has none."""
    source = tmp_path / "use.py"
    source.write_text(
        "import beamcam\n"
        "reading = beamcam.read('a.nc1')\n"
        "text: str = beamcam.post(reading.parts).text\n"
        "count: int = len(beamcam.plan(reading.parts, 'beamline').operations)\n"
        "codes: list[str] = [d.code for d in beamcam.verify(text, reading.parts)]\n"
        "beamcam.post(reading.parts, bar='long')\n"
    )
    done = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", "--follow-imports=silent",
         "--cache-dir", str(tmp_path / "cache"), str(source)],
        cwd=ROOT, capture_output=True, text=True,
    )  # fmt: skip
    assert "use.py:6: error" in done.stdout
    assert done.stdout.count("use.py:") == 1, done.stdout
