"""The figures of the shipped machine files, beside tables written by hand.

Facts of the beam cell: a saw KBS 1010 DG (1010 x 500, feed 2500 mm/min, mitre -45 to 60), a drill
KDXS 1015 (1000 x 500, feed 20000 mm/min, 150 to 2500 rpm, three spindles of five stations, drills
of 8 to 50), drills 778.56 behind the saw, a kerf of 4.04, a first part at 71.12, and a program that
ran. Facts of the tables: the stepper's lead of 2 mm in 200 steps, 800 x 500; the encoder's 65 mm in
512 counts, arrival within 0.005, 30 mm back off the limit switch.
"""

from math import nan

import pytest
from msgspec.structs import replace

from beamcam.machine import Machine, load, shipped

BARS = ("beamline", "beamline-annex", "beamline-pusher")

#: Key of the file: its value on each of `BARS`.
LINES: dict[str, tuple[object, object, object]] = {
    "format.length_decimals": (3, 1, 3),
    "format.angle_decimals": (3, 2, 3),
    "format.feed_unit": ("mm/s",) * 3,
    "format.number_blocks": (True,) * 3,
    "layout.order": ("saw-drill", "saw-drill", "drill-saw"),
    "layout.min_bar": (1200, 1200, 0),
    "layout.default_bar": (12000,) * 3,
    "layout.max_bar": (18000, 18000, 15500),
    "layout.min_part": (100, 100, 120),
    "layout.min_bar_left": (1200, 1200, 1200),
    "layout.front_trim": (20, 71.12, 15),
    "layout.end_trim": (0, 0, 0),
    "layout.dead_zone": (0, 0, 280),
    "layout.min_remnant": (1200, 1200, 1500),
    "layout.profiles": (("I", "U", "L"), ("I", "U"),
                        ("I", "U", "L", "M", "C", "T", "RO", "RU", "B")),
    "saw.x": (0, 0, 1250),
    "saw.kerf": (4.04, 4.04, 1.6),
    "saw.kerf_along": ("normal", "x", "normal"),
    "saw.pivot": ("o", "o", "u"),
    "saw.zero_angle": (0, 0, 90),
    "saw.angle_sign": (1, 1, 1),
    "saw.tilt_sign": (1, 1, 1),
    "saw.min_angle": (-45, -45, 25),
    "saw.max_angle": (60, 60, 155),
    "saw.max_height": (1010,) * 3,
    "saw.max_width": (500,) * 3,
    "saw.feed_mm_min": (2500, 2500, 80),
    "saw.min_mitre": (0.2,) * 3,
    "saw.min_tilt": (0, 0, -65),
    "saw.max_tilt": (0, 0, 65),
    "saw.compound": (False, False, True),
    "saw.common_cuts": (True, False, True),
    "drill.x": (778.56, 778.56, 0),
    "drill.max_height": (1000,) * 3,
    "drill.max_width": (500,) * 3,
    "drill.merge_tolerance": (0.1,) * 3,
    "drill.clearance": (5,) * 3,
    "drill.breakthrough": (2,) * 3,
    "drill.min_speed_rpm": (150,) * 3,
    "drill.max_speed_rpm": (2500,) * 3,
    "drill.max_feed_mm_min": (20000,) * 3,
    "drill.same_tool_tolerance": (0.02,) * 3,
    "drill.duplicate_tolerance": (0.01,) * 3,
    "drill.runout_pitches": (3,) * 3,
    "drill.sink_tolerance": (0.2,) * 3,
    "drill.path_tolerance": (0.02,) * 3,
    "drill.mark_depth": (0.3,) * 3,
    "drill.punch_depth": (1,) * 3,
    "drill.min_edge_distance": (3,) * 3,
    "drill.slots": ("drill-mill",) * 3,
    "times.saw_s": (6, 6, 9),
    "times.spindle_s": (1.5, 1.5, 1.2),
    "times.tool_change_s": (8, 8, 6),
    "times.spindle_change_s": (0.5, 0.5, 0.4),
    "times.manual_change_s": (90, 90, 75),
    "sections": ({"I": 1, "U": 2, "L": 3}, {"I": 1, "U": 3, "L": 3},
                 {"I": 1, "U": 2, "L": 3, "M": 4, "C": 5, "T": 6, "RO": 7, "RU": 8, "B": 9}),
    "marks.text": ("list", "list", "make"),
    "marks.points": ("refuse", "refuse", "make"),
    "marks.contours": ("refuse", "refuse", "make"),
    "marks.unit": ("none", "none", "scribe"),
    "marks.height_of": ("capital",) * 3,
}  # fmt: skip


def value(machine: Machine, key: str) -> object:
    found: object = machine
    for word in key.split("."):
        found = getattr(found, word)
    return dict(found) if key == "sections" else found  # type: ignore[call-overload]


@pytest.mark.parametrize("at", range(3), ids=BARS)
def test_a_line(at: int) -> None:
    machine = load(BARS[at])
    assert {key: value(machine, key) for key in LINES} == {k: row[at] for k, row in LINES.items()}


@pytest.mark.parametrize("name", BARS)
def test_its_spindles_axes_and_fits(name: str) -> None:
    machine = load(name)
    assert machine.drill is not None
    # Left flange (o) 1, web (v) 2, right flange (u) 3, five stations each; both flanges are 13.
    assert [(s.number, s.face, s.stations) for s in machine.spindles] == [
        (1, "o", 5), (2, "v", 5), (3, "u", 5),
    ]  # fmt: skip
    assert [(p.number, p.faces) for p in machine.pairs] == [(13, ("o", "u"))]
    assert [(s.across.axis, s.stroke.axis) for s in machine.spindles] == [
        ("Z", "Y"), ("Y", "Z"), ("Z", "Y"),
    ]  # fmt: skip
    # EN 1090-2 lets a hole be 0.5 mm off; holes up to 20 take a drill of +0.4, -0.3.
    assert [(f.up_to, f.plus, f.minus) for f in machine.drill.fits] == [
        (20, 0.4, 0.3), (50, 0.5, 0.3),
    ]  # fmt: skip
    # The nine axes in the order of the registers.
    stop = "pusher" if name == "beamline-pusher" else "stop"
    assert [axis.name for axis in machine.axes] == [
        stop, "left drill vertical", "left drill horizontal", "top drill horizontal",
        "top drill vertical", "right drill vertical", "right drill horizontal", "saw rotation",
        "saw vertical",
    ]  # fmt: skip
    assert [(axis.moves, axis.spindle) for axis in machine.axes] == [
        ("X", None), ("Z", 1), ("Y", 1), ("Y", 2), ("Z", 2), ("Z", 3), ("Y", 3), ("angle", None),
        ("saw", None),
    ]  # fmt: skip
    turn = (25, 155) if name == "beamline-pusher" else (-45, 60)
    assert [(axis.min, axis.max) for axis in machine.axes] == [
        (0, None), (-320, 200), (-20, 520), (-500, 500), (-20, 540), (-320, 200), (-20, 520), turn,
        (0, 1100),
    ]  # fmt: skip
    assert [axis.speed for axis in machine.axes] == [*[333.3] * 7, 6, 41.667]
    assert [axis.acceleration for axis in machine.axes] == [500, *[1000] * 6, 12, 100]
    # Strokes begin at the clearance, the saw stands square.
    square = 90 if name == "beamline-pusher" else 0
    assert [axis.park for axis in machine.axes] == [0, 0, -5, 0, -5, 0, -5, square, 0]
    assert machine.modbus.scales == (1, *[0.1] * 8)
    assert machine.modbus.values == "int16"


#: Speed in m/min and feed in mm of a turn, up to 10, 16, 24, 32 and 50 mm.
FEEDS = {
    ("S460N", "hss"): (15, 0.10, 0.14, 0.18, 0.22, 0.25),
    ("S460N", "carbide"): (55, 0.12, 0.16, 0.20, 0.23, 0.26),
    ("1.4301", "hss"): (12, 0.10, 0.14, 0.18, 0.22, 0.25),
    ("1.4301", "carbide"): (45, 0.10, 0.14, 0.17, 0.20, 0.22),
    ("S235JR", "hss"): (30, 0.16, 0.22, 0.28, 0.33, 0.38),
    ("S235JR", "carbide"): (90, 0.18, 0.24, 0.28, 0.32, 0.36),
    ("S355J2", "hss"): (25, 0.14, 0.20, 0.25, 0.30, 0.35),
    ("S355J2", "carbide"): (80, 0.16, 0.22, 0.26, 0.30, 0.34),
    ("", "hss"): (25, 0.14, 0.20, 0.25, 0.30, 0.35),
    ("", "carbide"): (80, 0.16, 0.22, 0.26, 0.30, 0.34),
}


@pytest.mark.parametrize("name", BARS)
def test_its_table_of_cutting_data(name: str) -> None:
    from fnmatch import fnmatchcase

    drill = load(name).drill
    assert drill is not None
    drills = [row for row in drill.cutting if row.kind == "drill"]
    for (grade, material), (speed, *feeds) in FEEDS.items():
        rows = [
            row for row in drills
            if row.tool_material == material
            and any(fnmatchcase(grade, pattern) for pattern in row.grade.split("|"))
        ]  # fmt: skip
        said = [(row.up_to, row.speed_m_min, row.feed_per_turn) for row in rows[:5]]
        assert said == [
            (size, speed, feed) for size, feed in zip((10, 16, 24, 32, 50), feeds, strict=True)
        ]
    others = {r.kind: (r.up_to, r.speed_m_min, r.feed_per_turn) for r in drill.cutting
              if r.kind != "drill"}  # fmt: skip
    assert others == {
        "tap": (30, 8, 1), "countersink": (60, 18, 0.12), "mill": (40, 90, 0.15),
        "punch": (20, 2, 1), "scribe": (20, 4, 1),
    }  # fmt: skip


def test_the_tools_of_the_lines() -> None:
    for name in BARS[:2]:
        (drills,) = load(name).tools
        # 8 to 50 in whole millimetres, halves up to 13.5 and the inch sizes of structural bolts.
        whole = [*range(8, 51)]
        halves = [n + 0.5 for n in range(8, 14)]
        inches = [17.46, 20.64, 23.81, 26.99, 30.16, 33.34]
        assert sorted(drills.sizes) == sorted([*whole, *halves, *inches])
        assert (drills.point_deg, drills.tool_material) == (118, "hss")
    sets = load("beamline-pusher").tools
    assert [(t.kind, t.point_deg) for t in sets] == [
        ("drill", 118), ("tap", 118), ("countersink", 90), ("countersink", 180), ("mill", 180),
        ("punch", 90), ("scribe", 90),
    ]  # fmt: skip
    # 1/16 in is 1.5875: 9, 11, 13, 15, 17, 19 and 21 of them.
    sixteenths = [14.2875, 17.4625, 20.6375, 23.8125, 26.9875, 30.1625, 33.3375]
    metric = [5, 6, 6.8, 7, 8, 8.5, 9, 10, 10.2, *range(11, 18), 17.5, *range(18, 27), 26.5,
              *range(27, 41)]  # fmt: skip
    assert sorted(sets[0].sizes) == pytest.approx(sorted([*metric, *sixteenths]))
    assert [tools.sizes for tools in sets[2:]] == [
        (20, 32, 50), (11, 15, 18, 20, 26, 33, 40), (8, 12, 16, 20), (3,), (1,),
    ]  # fmt: skip
    assert sets[4].largest_hole == 160


#: Up to a thickness: feed in mm/min, pierce in s, kerf, pierce height, cut height.
CHARTS = {
    "plate-linuxcnc": [
        (3, 5200, 0.2, 1.2, 3.8, 1.5), (6, 2300, 0.5, 1.5, 3.8, 1.5), (12, 900, 0.9, 1.9, 4, 1.6),
        (16, 1600, 0.8, 2.2, 6, 3), (20, 1050, 1.2, 2.4, 7, 3), (25, 650, 1.5, 2.7, 8, 4),
        (32, 420, 2, 3.1, 9, 5),
    ],
    "plate-codesys": [
        (3, 4800, 0.2, 1.2, 3.8, 1.5), (6, 2100, 0.5, 1.5, 3.8, 1.5), (12, 840, 0.9, 1.9, 4, 1.6),
        (16, 1500, 0.8, 2.2, 6, 3), (20, 980, 1.2, 2.4, 7, 3), (25, 600, 1.5, 2.7, 8, 4),
        (32, 390, 2, 3.1, 9, 5),
    ],
    "plate-oxyfuel": [
        (6, 620, 0.5, 1.5, 10, 6), (12, 520, 1, 1.8, 10, 6), (20, 430, 1, 2, 12, 7),
        (30, 360, 1.5, 2.4, 14, 8), (50, 270, 2.5, 3, 16, 9), (75, 200, 4, 3.8, 18, 10),
        (100, 150, 6, 4.6, 20, 12),
    ],
    "plate-mach3": [
        (3, 5200, 0.2, 1.2, 3.8, 1.5), (6, 2300, 0.5, 1.5, 3.8, 1.5), (12, 900, 0.9, 1.9, 4, 1.6),
        (20, 1050, 1.2, 2.4, 7, 3), (32, 420, 2, 3.1, 9, 5),
    ],
    "plate-qtplasmac": [
        (3, 5200, 0.2, 1.2, 3.8, 1.5), (6, 2300, 0.5, 1.5, 3.8, 1.5), (12, 900, 0.9, 1.9, 4, 1.6),
        (20, 1050, 1.2, 2.4, 7, 3), (32, 420, 2, 3.1, 9, 5),
    ],
}  # fmt: skip
#: Key of [torch]: its value on the first three of `CHARTS`, in their order; the others are as the
#: first.
TORCHES: dict[str, tuple[object, object, object]] = {
    "length": (3000,) * 3, "width": (1500,) * 3, "thickness": (6, 6, 20), "margin": (10,) * 3,
    "tolerance": (0.02,) * 3, "gap": (0.05,) * 3, "lead_in": (3, 3, 6), "lead_out": (1, 1, 2),
    "lead": ("arc",) * 3, "kerf_by": ("offset",) * 3, "direction": ("climb",) * 3,
    "min_hole": (4, 4, 10), "min_hole_share": (0.8, 0.8, 1), "min_bevel": (1,) * 3,
    "cross": (5,) * 3, "arc_limit": (0.005,) * 3, "min_radius": (0.01, 0.05, 0.01),
    "traverse_mm_min": (20000,) * 3,
}  # fmt: skip


@pytest.mark.parametrize("at", range(5), ids=CHARTS)
def test_a_torch_table(at: int) -> None:
    name = [*CHARTS][at]
    torch = load(name).torch
    assert torch is not None
    like = at if at < 3 else 0
    assert {key: getattr(torch, key) for key in TORCHES} == {k: r[like] for k, r in TORCHES.items()}
    cuts = [row for row in torch.rows if row.process == "cut" and row.material == "mild steel"]
    assert [
        (r.up_to, r.feed_mm_min, r.pierce_s, r.kerf, r.pierce_height, r.cut_height) for r in cuts
    ] == CHARTS[name]
    # A thicker plate takes longer to pierce and leaves a wider kerf, by one torch or the next.
    assert [r.kerf for r in cuts] == sorted(r.kerf for r in cuts)
    (mark,) = (row for row in torch.rows if row.process == "mark")
    assert (mark.feed_mm_min, mark.kerf, mark.up_to) == (3000, 0, cuts[-1].up_to)
    axes = [("X", 400, 2000), ("Y", 400, 2000)]
    if name == "plate-mach3":
        axes = [("X", 250, 1000), ("Y", 250, 1000), ("Z", 80, 800)]
    assert [(a.moves, a.speed, a.acceleration) for a in load(name).axes] == axes
    assert load(name).format.length_decimals == (4 if "codesys" not in name else 3)
    assert load(name).format.feed_unit == ("mm/s" if "codesys" in name else "mm/min")


def test_the_heights_of_a_table_that_moves_z() -> None:
    """20 mm over the sheet between cuts; the switch trips 3 mm below it; Z 0 at the top."""
    torch = load("plate-mach3").torch
    assert torch is not None
    assert (torch.z, torch.thc, torch.touch) == ("program", "program", "each")
    assert (torch.clearance, torch.touch_height, torch.top) == (20, -3, 0)
    other = load("plate-qtplasmac").torch
    assert other is not None
    assert (other.z, other.thc, other.touch) == ("controller", "controller", "none")


def test_the_flame_of_the_oxyfuel_table() -> None:
    """It heats the longer the thicker the plate, and longer than it then takes to pierce."""
    torch = load("plate-oxyfuel").torch
    assert torch is not None
    rows = [row for row in torch.rows if row.process == "cut"]
    assert [row.preheat_s for row in rows] == [2.5, 4, 7, 10.5, 17.5, 28, 44]
    assert all(row.preheat_s > 2 * row.pierce_s for row in rows)


@pytest.mark.parametrize("name", ["plate-mach3", "plate-qtplasmac"])
def test_arcs_of_plasma_torches(name: str) -> None:
    """A thicker plate has a longer arc, and a torch of 130 A above 12 mm."""
    torch = load(name).torch
    assert torch is not None
    rows = [row for row in torch.rows if row.material == "mild steel"]
    assert [(row.amps, row.volts) for row in rows] == [
        (45, 110), (45, 120), (45, 135), (130, 145), (130, 165),
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("material", "chart"),
    [
        ("stainless steel", [(3, 4200, 1.4, 45), (6, 1500, 1.6, 45), (12, 1500, 2.4, 130),
                             (20, 700, 2.8, 130)]),
        ("aluminium", [(3, 6000, 1.5, 45), (6, 2400, 1.7, 45), (12, 2000, 2.6, 130),
                       (20, 1000, 3, 130)]),
    ],
)  # fmt: skip
def test_other_metals_on_a_plasma_table(material: str, chart: list[tuple[float, ...]]) -> None:
    torch = load("plate-qtplasmac").torch
    assert torch is not None
    rows = [row for row in torch.rows if row.material == material]
    assert [(row.up_to, row.feed_mm_min, row.kerf, row.amps) for row in rows] == chart
    assert [row.pierce_height for row in rows] == [3.8, 3.8, 6, 7]


#: The lasers' acrylic up to 2, 4 and 8 mm, wood up to 4 and 8: feed, and on grbl power and kerf.
LASERS = {
    "laser-stepper": [
        ("acrylic", 2, 1500, 0, 0), ("acrylic", 4, 700, 0, 0), ("acrylic", 8, 240, 0, 0),
        ("wood", 4, 900, 0, 0), ("wood", 8, 300, 0, 0),
    ],
    "laser-grbl": [
        ("acrylic", 2, 1500, 800, 0.15), ("acrylic", 4, 700, 900, 0.18),
        ("acrylic", 8, 240, 1000, 0.22), ("wood", 4, 900, 900, 0.2), ("wood", 8, 300, 1000, 0.25),
    ],
}  # fmt: skip


@pytest.mark.parametrize("name", LASERS)
def test_a_laser(name: str) -> None:
    """800 x 500 mm, sheets of 8 mm at most."""
    torch = load(name).torch
    assert torch is not None
    assert (torch.length, torch.width, torch.thickness) == (800, 500, None)
    assert max(row.up_to for row in torch.rows) == 8
    cuts = [row for row in torch.rows if row.process == "cut"]
    assert [(r.material, r.up_to, r.feed_mm_min, r.power, r.kerf) for r in cuts] == LASERS[name]
    others = {r.process: (r.up_to, r.feed_mm_min, r.power) for r in torch.rows if r not in cuts}
    assert others == (
        {"mark": (8, 3000, 120), "engrave": (8, 3500, 300)} if name == "laser-grbl"
        else {"mark": (8, 1800, 0), "engrave": (8, 1800, 0)}
    )  # fmt: skip


def test_the_steps_of_the_laser() -> None:
    """2 mm a turn in 200 steps: 0.01 mm a step, 100 mm/s are 10 kHz; the words of its sequence."""
    stepper = load("laser-stepper").stepper
    assert stepper is not None
    assert (stepper.pitch, stepper.steps_per_turn, stepper.max_hz) == (2, 200, 10000)
    assert (stepper.traverse_mm_s, stepper.acceleration, stepper.jerk) == (80, 500, 20000)
    assert stepper.step == pytest.approx(0.01)
    assert stepper.sequence == ("00", "01", "10", "11")
    assert stepper.reversed_axes == ()


def test_the_axes_of_the_two_axis_table() -> None:
    """65 mm in 512 counts is 0.127 mm a count."""
    triggers = load("table-simotion").triggers
    assert triggers is not None
    assert (triggers.counts_per_turn, triggers.travel_per_turn) == (512, 65)
    assert triggers.count == pytest.approx(0.127, abs=0.0001)
    assert (triggers.in_position, triggers.back_off, triggers.cycle_s) == (0.005, 30, 0.025)
    assert (triggers.acceleration, triggers.cycles_per_chord) == (100, 3)
    assert (triggers.traverse_mm_s, triggers.homing_mm_s, triggers.standstill) == (20, 10, 0.0001)
    # Within two counts an actual position has arrived.
    assert triggers.arrival_window == pytest.approx(2 * 65 / 512, abs=0.01)
    # The rounded rectangle runs at 8 mm/s, 480 mm/min.
    torch = load("table-simotion").torch
    assert torch is not None
    assert [(r.process, r.up_to, r.feed_mm_min, r.pierce_s) for r in torch.rows] == [
        ("cut", 5, 480, 0.3), ("cut", 12, 120, 0.8), ("mark", 12, 1200, 0),
    ]  # fmt: skip


#: What a colour means on each table: red cuts, blue marks; a laser engraves black.
STEEL = {"red": "cut", "white": "cut", "black": "cut", "blue": "mark"}
LASER = {"red": "cut", "blue": "mark", "lime": "mark", "black": "engrave"}
PLATE = {**STEEL, "yellow": "mark"}
COLOURS = {
    **dict.fromkeys(("plate-linuxcnc", "plate-oxyfuel", "plate-codesys"), PLATE),
    **dict.fromkeys(("plate-mach3", "plate-qtplasmac"), PLATE),
    "table-simotion": STEEL, "table-plcopen": STEEL, "laser-grbl": LASER, "laser-stepper": LASER,
}  # fmt: skip


def test_every_machine_stands_here() -> None:
    copers = {"coper-linuxcnc", "coper-tilt-linuxcnc", "tube-linuxcnc", "tube-surface"}
    assert {*BARS, *COLOURS, *copers} == set(shipped())
    for name, colours in COLOURS.items():
        torch = load(name).torch
        assert torch is not None
        assert dict(torch.colours) == colours


#: Middle of the bodies of spindles and blade along X: where the drills and the saw stand.
STATIONS = {"beamline": (778.56, 0), "beamline-annex": (778.56, 0), "beamline-pusher": (0, 1250)}


@pytest.mark.parametrize("name", BARS)
def test_what_may_strike_stands_where_it_works(name: str) -> None:
    found = {body.name: body for body in load(name).bodies}
    figures = {"height": 300.0, "width": 150.0}
    drills, saw = STATIONS[name]
    for spindle in ("left spindle", "top spindle", "right spindle"):
        x = [end[0](figures) for end in (found[spindle].min, found[spindle].max)]
        assert x == pytest.approx([drills - 60, drills + 60])
    assert found["saw blade"].pivot is not None
    # A cut counts on the edge of o, at -Y as the web lies, or on that of u.
    edge = 150 if name == "beamline-pusher" else -150
    assert [place(figures) for place in found["saw blade"].pivot] == pytest.approx([saw, edge])


#: Length, width and the largest section of the saw by the angle off square: about 1010 cos(angle).
SECTIONS = [(0, 1010, 500), (15, 970, 500), (30, 870, 500), (45, 710, 500), (60, 500, 500)]


@pytest.mark.parametrize("name", BARS)
def test_the_reach_of_a_turned_blade(name: str) -> None:
    saw = load(name).saw
    assert saw is not None
    assert [(s.max_angle, s.max_height, s.max_width) for s in saw.max_sections] == SECTIONS


#: Places across and along the stroke for figures of an IPE300: face, y, depth, tip -> across,
#: start, bottom. Web Y = height / 2 - y (267.93 on 380 gives -77.9), flange Z = 188.6 - y (50
#: gives 138.6), both as the program that ran has them; the annex strokes 150, or half the height.
STROKES = [
    ("beamline", "v", 80, 70, -5, 71.45 + 9.1 + 6.61),
    ("beamline", "o", 45, 143.6, -5, 9.1 + 6.61),
    ("beamline", "u", 105, 83.6, -5, 9.1 + 6.61),
    ("beamline-annex", "v", 80, 70, 0, 150),
    ("beamline-annex", "o", 50, 138.6, 0, 150),
    ("beamline-annex", "u", 105, 83.6, 0, 150),
    ("beamline-pusher", "v", 220, -70, -5, 71.45 + 9.1 + 6.61),
    ("beamline-pusher", "o", 45, 143.6, -5, 9.1 + 6.61),
    ("beamline-pusher", "u", 105, 83.6, -5, 9.1 + 6.61),
]


@pytest.mark.parametrize(("name", "face", "y", "across", "start", "bottom"), STROKES)
def test_where_a_spindle_goes(
    name: str, face: str, y: float, across: float, start: float, bottom: float
) -> None:
    (spindle,) = (s for s in load(name).spindles if s.face == face)
    figures = {
        "height": 300.0, "width": 150.0, "flange_thickness": 10.7, "web_thickness": 7.1,
        "thickness": 7.1 if face == "v" else 10.7, "face_depth": 71.45 if face == "v" else 0.0,
        "y": y, "depth": 9.1, "tip": 6.61, "clearance": 5.0,
    }  # fmt: skip
    assert spindle.across.position(figures) == pytest.approx(across)
    assert spindle.stroke.retract(figures) == pytest.approx(start)
    assert spindle.stroke.bottom(figures) == pytest.approx(bottom)
    near = nan if spindle.stroke.approach is None else spindle.stroke.approach(figures)
    if face == "v" and name != "beamline-annex":
        assert near == pytest.approx(66.45)  # 5 before the web


def test_figures_of_the_coper() -> None:
    coper = load("coper-linuxcnc").coper
    assert coper is not None
    assert [(r.up_to, r.feed_mm_min, r.kerf, r.pierce_s) for r in coper.rows] == [
        (6, 4200, 2.0, 0.3), (10, 3000, 2.2, 0.4), (13, 2550, 2.4, 0.5), (16, 2200, 2.6, 0.6),
        (18, 1970, 2.7, 0.7), (20, 1750, 2.8, 0.8), (22, 1550, 3.0, 0.9), (25, 1350, 3.2, 1.0),
        (28, 1150, 3.4, 1.2),
        (32, 950, 3.6, 1.5), (36, 780, 3.9, 1.8), (40, 650, 4.2, 2.2), (45, 520, 4.5, 2.6),
        (50, 420, 4.8, 3.0),
    ]  # fmt: skip
    # Each feed stands for one thickness, by which the read-back knows how deep a cut is.
    assert len({row.feed_mm_min for row in coper.rows}) == len(coper.rows)
    assert {(row.process, row.cut_height) for row in coper.rows} == {("cut", 3.0)}
    assert (coper.corner_radius, coper.trim, coper.lead, coper.k_area) == (10, 30, 8, "pass")


def test_the_tube_machine_has_the_torch_of_the_coper() -> None:
    tube, coper = load("tube-linuxcnc").coper, load("coper-linuxcnc").coper
    assert tube is not None
    assert coper is not None
    assert tube.rows == coper.rows
    assert tube.profiles == ("RO", "M", "I", "U", "L", "T", "C")
    assert (tube.turns, tube.y, tube.chuck, tube.seam) == ("bar", "follows", 250, 0)
    # Outer corners of EN 10219-2: two walls up to 6 mm, two and a half up to 10, else three.
    walls = (3.0, 6.0, 6.3, 8.0, 10.0, 12.5, 16.0)
    radii = [tube.outer_radius(0.0, wall) for wall in walls]
    assert radii == [6.0, 12.0, 15.75, 20.0, 25.0, 37.5, 48.0]
    surface = load("tube-surface").coper
    assert surface == replace(tube, profiles=("RO",), a_unit="mm")


def test_the_torch_that_tilts_is_that_of_the_coper() -> None:
    tilting, upright = load("coper-tilt-linuxcnc"), load("coper-linuxcnc")
    assert tilting.coper is not None
    assert upright.coper is not None
    assert (tilting.coper.rows, tilting.coper.profiles) == (
        upright.coper.rows, upright.coper.profiles
    )  # fmt: skip
    assert (tilting.coper.tilt, upright.coper.tilt) == (45.0, 0.0)
    (axis,) = [axis for axis in tilting.axes if axis.moves == "B"]
    assert axis.limits == (-46.0, 46.0)
    assert [a for a in tilting.axes if a is not axis] == list(upright.axes)
    assert tilting.words.turn == ("G0 A{a} B{b}",)
