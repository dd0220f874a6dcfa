"""Keys of a coper's table that contradict one another, or the words and axes of its machine."""

from collections.abc import Iterator
from math import hypot

from beamcam.machine.coper import TUBES, Coper
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
    for name in ("height", "width"):
        template = getattr(words, f"measured_{name}")
        if template and sum(line.count("{" + name) for line in template) != 1:
            yield f"words.measured_{name}", list(template), f"{{{name}}} once"
    round_bar = coper.turns == "bar"
    for name in ("a", "inverse"):
        if any("{" + name in line for line in words.feed) != round_bar:
            expected = f"{{{name}}} where coper.turns is bar, and nowhere else"
            yield "words.feed", list(words.feed), expected
    if not {*coper.profiles} <= (
        allowed := {"I", "U", "L", "T", "C", *(TUBES if round_bar else ())}
    ):
        expected = f"some of {', '.join(sorted(allowed))} where coper.turns is {coper.turns}"
        yield "coper.profiles", list(coper.profiles), expected
    yield from _tilt_faults(machine, coper)
    yield from _fixed_faults(machine, coper)
    for k, zone in enumerate(coper.supports):
        if zone.min >= zone.max:
            yield f"coper.supports.{k}.max", zone.max, f"more than min, {zone.min:g}"
    if coper.a_unit == "mm" and {*coper.profiles} != {"RO"}:
        yield "coper.a_unit", "mm", "deg, as only round tubes (RO) turn evenly with their surface"
    for name, found, code in (("corner", coper.corner, "M"), ("lip", coper.lip, "C")):
        if found and code not in coper.profiles:
            yield f"coper.{name}", found, f"none where coper.profiles has no {code}"
    yield from _reach_faults(machine, coper)
    if coper.tcp == bool(coper.pivot):
        expected = "0 where tcp is true, and above 0 where it is false"
        yield "coper.pivot", coper.pivot, expected
    if not any(row.process == "cut" for row in coper.rows):
        yield "coper.rows", [row.process for row in coper.rows], "a row for cut"
    for index, row in enumerate(coper.rows):
        yield from _row_faults(f"coper.rows.{index}", row, coper)
    yield from _feed_faults(coper)
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


def _fixed_faults(machine: Machine, coper: Coper) -> Iterator[Fault]:
    """A torch without Y over sections that are square to it beside their axis too, or with words
    for Y."""
    if coper.y == "follows":
        return
    if coper.turns == "torch" or {*coper.profiles} != {"RO"}:
        expected = "RO alone, and turns = 'bar', where coper.y is fixed"
        yield "coper.profiles", list(coper.profiles), expected
    for name in ("turn", "traverse", "feed"):
        if any("{y}" in line for line in getattr(machine.words, name)):
            expected = "no {y} where coper.y is fixed"
            yield f"words.{name}", list(getattr(machine.words, name)), expected
    for k, axis in enumerate(machine.axes):
        if axis.moves == "Y":
            yield f"axes.{k}.moves", "Y", "no such axis where coper.y is fixed"


def _reach_faults(machine: Machine, coper: Coper) -> Iterator[Fault]:
    """Axes that do not come to the corners of the bars that turn below the torch, or to the webs
    between their flanges."""
    if coper.turns == "torch" or {*coper.profiles} == {"RO"}:
        return
    half, long = coper.max_width / 2, hypot(coper.max_height, coper.max_width) / 2
    wide, low, what = max(half, coper.max_height / 2), 0.0, "rectangular tubes"
    if not {*coper.profiles} <= {*TUBES}:
        beyond = coper.over + max((row.kerf for row in coper.rows), default=0.0)
        wide, low = wide + beyond, -half
        what = "walls that turn; else coper.profiles of RO and M alone"
    for name, least, most in (("Y", -wide, wide), ("Z", low, long + coper.clearance)):
        for k, axis in enumerate(machine.axes):
            if axis.moves == name and (axis.limits[0] > least or axis.limits[1] < most):
                end = "max" if axis.limits[1] < most else "min"
                expected = f"{least:g} to {most:.4g} at least, for {what}"
                yield f"axes.{k}.{end}", getattr(axis, end), expected


def _feed_faults(coper: Coper) -> Iterator[Fault]:
    """Feeds that do not tell the rows apart, or that figures between two rows would not fall by."""
    feeds = [(row.feed_mm_min, row.material) for row in coper.rows]
    for index, row in enumerate(coper.rows):
        key, feed = f"coper.rows.{index}.feed_mm_min", row.feed_mm_min
        if feeds.index(feeds[index]) != index:
            yield key, feed, "another feed for each thickness, which is told by it"
        thinner = (o for o in coper.rows if o.material == row.material and o.up_to < row.up_to)
        if coper.between_rows == "interpolate" and any(o.feed_mm_min <= feed for o in thinner):
            expected = "a feed below those of thinner steel, as between_rows is interpolate"
            yield key, feed, expected


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
