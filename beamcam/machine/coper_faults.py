"""Checks of the torch that goes round a profile that involve several keys."""

from collections.abc import Iterator
from math import hypot

from beamcam.machine.coper import Coper
from beamcam.machine.faults import Fault
from beamcam.machine.machine import Machine
from beamcam.machine.torch import TorchRow

MOST_TILT_DEG = 60.0  #: farther over, the torch lies on the steel


def coper_faults(machine: Machine) -> Iterator[Fault]:
    """Each key of a coper that contradicts another."""
    coper, words = machine.coper, machine.words
    if coper is None:
        return
    if machine.stock != "profile":
        yield "coper", machine.stock, "no such table, or stock = 'profile'"
    if machine.controller != "linuxcnc":
        yield "controller", machine.controller, "linuxcnc, which runs a torch round a profile"
    for name in ("turn", "traverse", "feed", "cut_on", "cut_off"):
        if not getattr(words, name):
            yield f"words.{name}", [], "a template, since there is a coper"
    round_bar = coper.turns == "bar"
    for name in ("a", "inverse"):
        if any("{" + name in line for line in words.feed) != round_bar:
            expected = f"{{{name}}} where coper.turns is bar, and nowhere else"
            yield "words.feed", list(words.feed), expected
    if round_bar == bool({*coper.profiles} - {"RO", "M"}) or not (
        round_bar or {*coper.profiles}.isdisjoint({"RO", "M"})
    ):
        yield (
            "coper.profiles",
            list(coper.profiles),
            "RO and M where the bar turns, else I, U and L",
        )
    yield from _tilt_faults(machine, coper)
    if coper.corners and "M" not in coper.profiles:
        yield "coper.corners", len(coper.corners), "none where coper.profiles has no M"
    yield from _reach_faults(machine, coper)
    if coper.tcp == bool(coper.pivot):
        expected = "0 where tcp is true, and above 0 where it is false"
        yield "coper.pivot", coper.pivot, expected
    if not any(row.process == "cut" for row in coper.rows):
        yield "coper.rows", [row.process for row in coper.rows], "a row for cut"
    for index, row in enumerate(coper.rows):
        yield from _row_faults(f"coper.rows.{index}", row, coper)
    feeds = [(row.feed_mm_min, row.material) for row in coper.rows]
    for index, said in enumerate(feeds):
        if feeds.index(said) != index:
            expected = "another feed for each thickness, which is told by it"
            yield f"coper.rows.{index}.feed_mm_min", said[0], expected
    step = machine.format.resolution
    if not 4 * step <= coper.tolerance <= 1.0:
        expected = f"{4 * step:g} to 1 mm, four steps of its numbers at least"
        yield "coper.tolerance", coper.tolerance, expected
    if coper.head_width < coper.torch_width:
        yield "coper.head_width", coper.head_width, "at least torch_width"


def _tilt_faults(machine: Machine, coper: Coper) -> Iterator[Fault]:
    """A torch that tilts without an axis or a word for it, or the other way round."""
    if coper.tilt and (coper.turns == "bar" or coper.tilt > MOST_TILT_DEG):
        expected = f"at most {MOST_TILT_DEG:g}, and 0 where coper.turns is bar"
        yield "coper.tilt", coper.tilt, expected
    if any("{b}" in line for line in machine.words.turn) != bool(coper.tilt):
        expected = "{b} where coper.tilt is above 0, and nowhere else"
        yield "words.turn", list(machine.words.turn), expected
    axes = [(k, axis) for k, axis in enumerate(machine.axes) if axis.moves == "B"]
    if bool(axes) != bool(coper.tilt):
        yield "axes", len(machine.axes), "one that moves B where coper.tilt is above 0, else none"
    for k, axis in axes:
        if axis.limits[0] > -coper.tilt or axis.limits[1] < coper.tilt:
            yield f"axes.{k}.max", axis.max, f"-{coper.tilt:g} to {coper.tilt:g} at least"


def _reach_faults(machine: Machine, coper: Coper) -> Iterator[Fault]:
    """Axes that do not come to the corners of the tubes that they are for."""
    if "M" not in coper.profiles:
        return
    half, long = coper.max_width / 2, hypot(coper.max_height, coper.max_width) / 2
    wide = max(half, coper.max_height / 2)
    for name, least, most in (("Y", -wide, wide), ("Z", 0.0, long + coper.clearance)):
        for k, axis in enumerate(machine.axes):
            if axis.moves == name and (axis.limits[0] > least or axis.limits[1] < most):
                expected = f"{least:g} to {most:.4g} at least, for rectangular tubes"
                yield f"axes.{k}.max", axis.max, expected


def _row_faults(key: str, row: TorchRow, coper: Coper) -> Iterator[Fault]:
    if row.process != "cut":
        yield f"{key}.process", row.process, "cut, as a coper does nothing else"
    for name in ("kerf", "cut_height", "pierce_height", "pierce_s"):
        if not getattr(row, name):
            yield f"{key}.{name}", 0.0, "a figure above 0, as the torch goes round the steel by it"
    if row.cut_height <= coper.play:
        yield f"{key}.cut_height", row.cut_height, f"more than play, {coper.play:g} mm"
    if row.pierce_height < row.cut_height:
        yield f"{key}.pierce_height", row.pierce_height, "at least cut_height"
    if row.passes != 1:
        yield f"{key}.passes", row.passes, "1, as a torch cuts through at once"
    if coper.corner_radius < row.kerf / 2:
        expected = f"at least {row.kerf / 2:g}, half the kerf of the widest row"
        yield "coper.corner_radius", coper.corner_radius, expected
    if coper.lead < row.pierce_radius:
        yield "coper.lead", coper.lead, f"at least {row.pierce_radius:g}, what piercing burns"
    if coper.trim < 2 * (coper.lead + row.kerf):
        expected = f"at least {2 * (coper.lead + row.kerf):g}, for leads and kerfs"
        yield "coper.trim", coper.trim, expected
