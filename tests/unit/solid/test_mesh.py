"""Solids as triangles: closed, as large as the steel, and each cut with the line that made it."""

import subprocess
import sys
from collections import Counter
from math import pi
from pathlib import Path

import numpy as np
import pytest

from beamcam.controllers import table_events
from beamcam.errors import BeamcamError
from beamcam.machine import load
from beamcam.model.part import Part
from beamcam.pictures import ReadProgram
from beamcam.pictures.program import bar_made
from beamcam.pipeline import post, read_file
from beamcam.setup_sheet.solid_data import Mesh, bar_meshes, sheet_meshes
from beamcam.solid.sheet_solid import rows_for, strokes_of

SAMPLES = Path(__file__).resolve().parents[3] / "samples" / "dstv"


def parts_of(*names: str) -> tuple[Part, ...]:
    return tuple(p for name in names for p in read_file(str(SAMPLES / f"{name}.nc1")).parts)


def volume(mesh: Mesh) -> float:
    """By the divergence theorem: positive where normals point outwards."""
    a, b, c = mesh.points[mesh.triangles].transpose(1, 0, 2)
    return float(np.sum(a * np.cross(b, c)) / 6)


def is_closed(mesh: Mesh) -> bool:
    """Whether each side of a triangle is that of one other, the other way round."""
    sides = Counter((int(t[k]), int(t[(k + 1) % 3])) for t in mesh.triangles for k in range(3))
    return all(sides[b, a] == count == 1 for (a, b), count in sides.items())


CHANNEL_MM2 = 2 * 75.0 * 11.5 + (200.0 - 23.0) * 8.5  #: without its root fillets


@pytest.mark.parametrize("chord", [0.05, 5.0])
def test_a_bar_is_closed_and_each_hole_has_its_line(chord: float) -> None:
    parts, machine = parts_of("channel", "tie", "channel"), load("beamline-annex")
    text = post(parts, machine).text
    made = bar_made(ReadProgram(text.encode(), machine, "bar.gcode", "", parts))
    meshes = bar_meshes(text, machine, parts, "bar.gcode", None, chord)
    assert all(is_closed(mesh) for mesh in meshes)
    assert all(volume(mesh) > 0.0 for mesh in meshes)
    lines = {int(line) for mesh in meshes for line in mesh.lines}
    assert {b.line for b in made.made.bores} | {c.line for c in made.made.cuts} <= lines
    drill_x = machine.drill.x if machine.drill else 0.0
    for bore in made.made.bores:
        places = np.concatenate([
            mesh.points[mesh.triangles[mesh.lines == bore.line]].reshape(-1, 3) for mesh in meshes
        ])  # fmt: skip
        radius, slack = bore.diameter / 2, chord + 0.02
        along = places[:, 0] - (bore.x - drill_x)
        assert along.min() == pytest.approx(-radius, abs=slack)
        assert along.max() == pytest.approx(radius, abs=slack)
    tie = next(m for m in meshes if 300.0 < np.ptp(m.points[:, 0]) < 330.0)
    holes = list(parts[1].holes)
    taken = sum(pi * h.diameter**2 / 4 * 8.5 for h in holes)
    fillets = volume(tie) - (parts[1].length * CHANNEL_MM2 - taken)
    assert 0.0 < fillets < 0.03 * parts[1].length * CHANNEL_MM2


def test_the_stock_itself_is_of_no_line() -> None:
    parts, machine = parts_of("tie"), load("beamline-annex")
    meshes = bar_meshes(post(parts, machine).text, machine, parts, "x", None, 0.05)
    for mesh in meshes:
        corners = mesh.points[mesh.triangles]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        outside = (normals[:, 1] > 0.999) & (corners[:, :, 1].min(axis=1) > 199.99)
        assert outside.any()
        assert set(mesh.lines[outside].tolist()) == {0}


def test_a_section_that_is_not_known_has_no_solid() -> None:
    parts, machine = parts_of("channel"), load("beamline-annex")
    text = post(parts, machine).text
    read = ReadProgram(text.encode(), machine, "bar.gcode")
    stock = Part("", bar_made(read).profile, 1000.0, parts[0].source)
    with pytest.raises(BeamcamError, match="what a solid can be made of"):
        bar_meshes(text, machine, (stock,), "bar.gcode", None, 0.05)


@pytest.mark.parametrize("chord", [0.05, 0.6])
def test_a_plate_has_its_holes_and_none_of_its_slugs(chord: float) -> None:
    """260 x 180 x 6 mm less a corner, two holes of 18, a slot of 34 x 14 and a square of 50."""
    parts, machine = parts_of("gusset"), load("plate-linuxcnc")
    assert machine.torch is not None
    text = post(parts, machine).text
    rows = rows_for(machine.torch, 6.0, "mild steel")
    kerf = next(row.kerf for row in rows if row.process == "cut")
    strokes = strokes_of(table_events(text, machine)[0], machine, rows, "x")
    (mesh,) = sheet_meshes(strokes, kerf, 6.0, chord)
    assert is_closed(mesh)
    corner = 60.0 * 80.0 / 2 + 20.0 * 80.0 + 20.0**2 * (1 - pi / 4)
    holes = 2 * pi * 81.0 + (20.0 * 14.0 + pi * 49.0) + 2500.0
    wanted = 6.0 * (260.0 * 180.0 - corner - holes)
    assert volume(mesh) == pytest.approx(wanted, rel=0.002 + chord / 100)
    assert (mesh.points[:, 2].min(), mesh.points[:, 2].max()) == (0.0, 6.0)
    cut = {stroke.moves[0].line for stroke in strokes if stroke.process == "cut"}
    assert set(mesh.lines.tolist()) == cut | {0}
    cuts = [s for s in strokes if s.process == "cut"]
    square = next(s for s in cuts if abs(s.moves[0].start[0] - 135.0) < 20.0
                  and s.moves[0].start[1] > 60.0)  # fmt: skip
    places = mesh.points[mesh.triangles[mesh.lines == square.moves[0].line]].reshape(-1, 3)
    assert np.ptp(places[:, 0]) == pytest.approx(50.0, abs=2 * chord + 0.1)
    assert np.ptp(places[:, 1]) == pytest.approx(50.0, abs=2 * chord + 0.1)


def test_two_parts_are_two_pieces() -> None:
    parts, machine = parts_of("gusset", "gusset"), load("plate-linuxcnc")
    assert machine.torch is not None
    rows = rows_for(machine.torch, 6.0, "mild steel")
    events, _ = table_events(post(parts, machine).text, machine)
    meshes = sheet_meshes(strokes_of(events, machine, rows, "x"), 1.6, 6.0, 0.05)
    assert len(meshes) == 2
    assert sheet_meshes([], 1.6, 6.0, 0.05) == []


# --- threads --------------------------------------------------------------------------------------


WORK = """
import os
from beamcam.solid.kernel import kernel
processors = os.sched_getaffinity(0)
m = kernel()
def work(): return (m.Manifold.sphere(10, 200) - m.Manifold.cube((15, 15, 15))).volume()
volume = work()
assert os.sched_getaffinity(0) == processors
assert len(os.listdir("/proc/self/task")) == 1, os.listdir("/proc/self/task")
child = os.fork()
if not child:
    os._exit(0 if work() == volume else 1)
assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
"""


@pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="no processes are forked here")
def test_it_starts_no_thread_that_a_forked_process_would_wait_for() -> None:
    done = subprocess.run([sys.executable, "-c", WORK], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
