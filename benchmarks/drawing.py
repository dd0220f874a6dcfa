"""Posting a large drawing and a jagged one, against ezdxf reading them.

    python benchmarks/drawing.py [--kerf]

The large drawing has 20,000 segments, 2,000 arcs and 500 splines; the jagged one 100 closed
contours with 200 sharp corners each and 2,500 open curves.

Of each it prints the processor time of `beamcam post` step by step, in a process that has its
libraries loaded, and the time that ezdxf takes to read the same DXF and to flatten its entities at
the tolerance of the machine; then the number of moves of both; and at the end both as processes of
their own, start and imports included, as a user waits for them, whose bytecode is at hand as that
of installed packages. Each figure is the least of three runs, taken in turns. The garbage collector
is tuned as in `beamcam post`, for ezdxf too. --kerf keeps off by half a kerf and leads in, which
takes two or three times as long to plan and to read back; the jagged drawing, in whose corners no
beam has room, is left out then.
"""

import os
import subprocess
import sys
import tempfile
from collections.abc import Callable
from inspect import getsource
from pathlib import Path
from time import process_time
from typing import TypeVar

import make_drawing
from script import arguments, start

from beamcam.checks.sheets.compare import verify_sheet
from beamcam.emitters import cutting
from beamcam.machine import load
from beamcam.machine.machine import Machine
from beamcam.machine.overlay import with_torch
from beamcam.model.program import Feed, Movement, Traverse
from beamcam.motion.sheet import sheet_program
from beamcam.pipeline import post, read_file
from beamcam.planning.sheet import plan_sheet
from beamcam.system import collector_seldom

RUNS = 3
Result = TypeVar("Result")


def least(work: Callable[[], Result]) -> tuple[float, Result]:
    """The least time of `RUNS` runs, and what the last gave."""
    best = float("inf")
    for _ in range(RUNS):
        start = process_time()
        result = work()
        best = min(best, process_time() - start)
    return best, result


def process_s(bytecode: Path, *arguments: str) -> float:
    """Processor time of a Python process of its own, whose bytecode is kept in a folder."""
    environment = {**os.environ, "PYTHONPYCACHEPREFIX": str(bytecode)}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    command = [sys.executable, *arguments]
    before = os.times()
    subprocess.run(command, check=True, stderr=subprocess.DEVNULL, env=environment)
    after = os.times()
    used = after.children_user - before.children_user
    return used + after.children_system - before.children_system


def by_ezdxf(path: Path, tolerance: float) -> int:
    """Reads a DXF and flattens its entities; the number of chords."""
    import ezdxf
    from ezdxf.path import make_path

    document = ezdxf.readfile(path)
    paths = (make_path(entity) for entity in document.modelspace())
    return sum(len(list(path.flattening(tolerance))) - 1 for path in paths)


def main() -> None:
    """Runs all and prints the table."""
    parser = arguments(__doc__)
    parser.add_argument("--kerf", action="store_true", help="keep off by half a kerf, lead in")
    kerf: bool = parser.parse_args().kerf
    collector_seldom()
    machine = load("plate-linuxcnc")
    if not kerf:
        machine = with_torch(machine, None, 0.0, lead="none")
    assert machine.torch is not None
    tolerance = machine.torch.tolerance
    with tempfile.TemporaryDirectory() as folder:
        drawing = make_drawing.make(20_000, 2_000, 500)
        dxf, svg = Path(folder) / "drawing.dxf", Path(folder) / "drawing.svg"
        make_drawing.write_dxf(drawing, dxf)
        make_drawing.write_svg(drawing, svg)
        sets = [(dxf, svg)]
        if not kerf:
            jagged = Path(folder) / "jagged.dxf"
            make_drawing.write_jagged(jagged)
            sets.append((jagged,))
        for paths in sets:
            theirs, chords = least(lambda path=paths[0]: by_ezdxf(path, tolerance))
            print(f"ezdxf reads and flattens {paths[0].name:12} {theirs:7.2f} s   {chords} moves")
            for path in paths:
                report(path, machine, theirs, chords)
            compare_processes(paths[0], tolerance, kerf)


def report(path: Path, machine: Machine, theirs: float, chords: int) -> None:
    """Posts a drawing step by step and as a whole, and prints how long that takes."""
    reading_s, reading = least(lambda: read_file(str(path)))
    plan_s, plan = least(lambda: plan_sheet(reading.parts, machine))
    motion_s, program = least(lambda: sheet_program(plan, machine, "JOB"))
    emit_s, text = least(lambda: cutting.emit(program, machine))
    verify_s, said = least(lambda: verify_sheet(text, reading.parts, machine))
    assert not said
    whole, _ = least(lambda: post(read_file(str(path)).parts, machine))
    moves = sum(isinstance(c, Traverse | Movement) for c in program.commands)
    lines = sum(type(c) is Feed for c in program.commands)
    print(
        f"beamcam post {path.name:14} {whole:7.2f} s   {moves} moves, {lines} of them lines: "
        f"{whole / theirs:.2f} of the time, {1 - moves / chords:.0%} fewer moves"
    )
    print(
        f"    read {reading_s:.2f}, plan {plan_s:.2f}, motion {motion_s:.2f}, emit {emit_s:.2f}, "
        f"read back {verify_s:.2f} s"
    )


def compare_processes(path: Path, tolerance: float, kerf: bool) -> None:
    """Posts a drawing by the command, reads and flattens it by ezdxf, in turns, and prints both."""
    alone = (
        f"from pathlib import Path\n{getsource(by_ezdxf)}by_ezdxf(Path({str(path)!r}), {tolerance})"
    )
    command = ["-m", "beamcam", "post", str(path), "-o", str(path.with_suffix(".ngc"))]
    if not kerf:
        command += ["--kerf", "0", "--lead", "none"]
    bytecode = path.parent / "bytecode"
    pairs = [(process_s(bytecode, "-c", alone), process_s(bytecode, *command)) for _ in range(RUNS)]
    theirs, ours = (min(times) for times in zip(*pairs, strict=True))
    print(
        f"as processes: ezdxf {theirs:.2f} s, beamcam post {ours:.2f} s: "
        f"{ours / theirs:.2f} of the time"
    )


if __name__ == "__main__":
    start(main)
