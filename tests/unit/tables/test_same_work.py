"""One part through three controllers: the same path, by each one's own interpreter."""

import numpy as np
import shapely

from beamcam.checks.steps.follow import Followed
from beamcam.checks.steps.outline import OutlineCheck
from beamcam.controllers import table_events
from beamcam.controllers.events import Move
from beamcam.controllers.step_table import Stream, binary_rows
from beamcam.emitters import step_table as forms
from beamcam.geometry.array_types import Floats
from beamcam.geometry.curves import Line
from beamcam.machine import load
from beamcam.machine.overlay import with_torch
from beamcam.machine.torch import LayerSettings
from beamcam.motion.steps import step_table
from beamcam.pipeline import post
from tests.distances import distances
from tests.unit.sheets.parts import box, contour, drawing

from .plant import DONE, Plant, units_of
from .shop import part, plan, program, table_machine

NAME = "rounded-rectangle"
FINE = 0.02


def by_codesys() -> shapely.LineString:
    from msgspec.structs import replace

    machine = load("plate-codesys")
    assert machine.torch is not None
    torch = replace(machine.torch, kerf_by="none", lead="none", lead_in=0.0, lead_out=0.0,
                    place="drawn", start="drawn", direction="drawn")  # fmt: skip
    machine = replace(machine, torch=torch)
    text = post([part(NAME)], machine).text
    points: list[tuple[float, float]] = []
    for event in table_events(text, machine)[0]:
        if isinstance(event, Move) and not event.rapid:
            curve = event.curve or Line(event.start, event.end)
            points += [curve.point(k / 200) for k in range(201)]
    return shapely.LineString(points)


def by_simotion() -> shapely.LineString:
    machine = table_machine()
    plant = Plant(units_of(program(NAME, "chain"), machine), machine)
    plant.press_start()
    plant.run_until(DONE, 600.0)
    return shapely.LineString(plant.points["cut"])


class Kept(OutlineCheck):
    """An outline that keeps all points of its strokes."""

    def begin(self, line: int) -> None:
        self.strokes = [*getattr(self, "strokes", []), []]

    def draw(self, points: Floats, corners: Floats | None = None) -> None:
        self.strokes[-1].append(points)


def by_stepper() -> shapely.LineString:
    machine = load("laser-stepper")
    table = step_table(plan(NAME, "laser-stepper"), machine, NAME)
    outline = Kept(None, machine, (), 0.0, 0.0, NAME)
    followed = Followed(machine, NAME, outline)
    assert machine.stepper is not None
    for rows in binary_rows(Stream(forms.as_bytes(table), NAME), machine.stepper):
        followed.follow(rows)
    followed.finish()
    assert followed.diagnostics == []
    (stroke,) = outline.strokes
    return shapely.LineString(np.concatenate(stroke))


def test_three_controllers_make_the_same_path() -> None:
    ways = [by_codesys(), by_simotion(), by_stepper()]
    assert all(abs(way.length - (80 + 20 * np.pi)) < 20 for way in ways)
    for k, a in enumerate(ways):
        for b in ways[k + 1 :]:
            assert farthest(a, b) <= FINE
            assert farthest(b, a) <= FINE


def farthest(a: shapely.LineString, b: shapely.LineString) -> float:
    """The greatest distance of `a` from `b`, looked at every 0.2 mm and at every corner."""
    return float(distances(shapely.get_coordinates(shapely.segmentize(a, 0.2)), b).max())


def test_the_controller_of_the_table_goes_on_by_the_overcut_in_each_pass() -> None:
    """Run with simulated axes: a square of 10 mm twice, each time 2 mm beyond its start."""
    own = {"red": LayerSettings(passes=2)}
    machine = with_torch(load("table-simotion"), {"red": "cut"}, settings=own, overcut=2.0)
    square = drawing(contour(box(5, 5, 10, 10)), thickness=3.0)
    plant = Plant(units_of(post((square,), machine, style="chain").text, machine), machine)
    plant.press_start()
    plant.run_until(DONE, 600.0)
    way = shapely.LineString(plant.points["cut"])
    ring = shapely.Polygon([(5, 5), (15, 5), (15, 15), (5, 15)]).exterior
    assert farthest(way, shapely.LineString(ring.coords)) <= FINE
    assert abs(way.length - (2 * 42 + 2)) < 0.2  # and back along the overcut, with the torch off
