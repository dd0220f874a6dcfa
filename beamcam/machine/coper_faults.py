"""Keys of a coper's table that contradict one another, or the words and axes of its machine."""

from collections.abc import Iterator
from math import hypot

from beamcam.machine.coper import TUBES, Coper
from beamcam.machine.faults import Fault, repeats
from beamcam.machine.machine import Machine
from beamcam.machine.torch import TorchRow


def coper_faults(machine: Machine) -> Iterator[Fault]:
    """Each key of a coper that contradicts another."""
    coper, words = machine.coper, machine.words
    if coper is None:
        return
    if machine.stock != "profile":
        yield "coper", "no such table, or stock = 'profile'", machine.stock
    if machine.controller != "linuxcnc":
        yield "controller", "linuxcnc, which runs a torch round a profile"
    for name in ("turn", "traverse", "feed", "cut_on", "cut_off"):
        if not getattr(words, name):
            yield f"words.{name}", "a template, since there is a coper"
    for name in ("height", "width"):
        template = getattr(words, f"measured_{name}")
        if template and sum(line.count("{" + name) for line in template) != 1:
            yield f"words.measured_{name}", f"{{{name}}} once"
    round_bar = coper.turns == "bar"
    for name in ("a", "inverse"):
        if any("{" + name in line for line in words.feed) != round_bar:
            yield "words.feed", f"{{{name}}} where coper.turns is bar, and nowhere else"
    allowed = {"I", "U", "L", "T", "C", *(TUBES if round_bar else ())}
    if not {*coper.profiles} <= allowed:
        expected = f"some of {', '.join(sorted(allowed))} where coper.turns is {coper.turns}"
        yield "coper.profiles", expected
    yield from _tilt_faults(machine, coper)
    yield from _fixed_faults(machine, coper)
    for k, zone in enumerate(coper.supports):
        if zone.min >= zone.max:
            yield f"coper.supports.{k}.max", f"more than min, {zone.min:g}"
    if coper.a_unit == "mm" and {*coper.profiles} != {"RO"}:
        yield "coper.a_unit", "deg, as only round tubes (RO) turn evenly with their surface"
    for name, code in (("corner", "M"), ("lip", "C")):
        if getattr(coper, name) and code not in coper.profiles:
            yield f"coper.{name}", f"none where coper.profiles has no {code}"
    yield from _reach_faults(machine, coper)
    if coper.tcp == bool(coper.pivot):
        yield "coper.pivot", "0 where tcp is true, and above 0 where it is false"
    processes = [row.process for row in coper.rows]
    if "cut" not in processes:
        yield "coper.rows", "a row for cut", processes
    for index, row in enumerate(coper.rows):
        yield from _row_faults(f"coper.rows.{index}", row, coper)
    for index, _ in repeats((row.feed_mm_min, row.material) for row in coper.rows):
        expected = "another feed for each thickness, which is told by it"
        yield f"coper.rows.{index}.feed_mm_min", expected
    least = 4 * machine.format.resolution
    if coper.tolerance < least:
        yield "coper.tolerance", f"{least:g} to 1 mm, four steps of its numbers at least"
    if coper.head_width < coper.torch_width:
        yield "coper.head_width", "at least torch_width"


def _tilt_faults(machine: Machine, coper: Coper) -> Iterator[Fault]:
    """A torch that tilts without an axis or a word for it, or the other way round."""
    if coper.tilt and coper.turns == "bar":
        yield "coper.tilt", "0 where coper.turns is bar"
    if any("{b}" in line for line in machine.words.turn) != bool(coper.tilt):
        yield "words.turn", "{b} where coper.tilt is above 0, and nowhere else"
    axes = [(k, axis) for k, axis in enumerate(machine.axes) if axis.moves == "B"]
    if bool(axes) != bool(coper.tilt):
        yield "axes", "one that moves B where coper.tilt is above 0, else none", len(machine.axes)
    for k, axis in axes:
        if axis.limits[0] > -coper.tilt or axis.limits[1] < coper.tilt:
            yield f"axes.{k}.max", f"-{coper.tilt:g} to {coper.tilt:g} at least"


def _fixed_faults(machine: Machine, coper: Coper) -> Iterator[Fault]:
    """A torch without Y over sections that are square to it beside their axis too, or with words
    for Y."""
    if coper.y == "follows":
        return
    if coper.turns == "torch" or {*coper.profiles} != {"RO"}:
        yield "coper.profiles", "RO alone, and turns = 'bar', where coper.y is fixed"
    for name in ("turn", "traverse", "feed"):
        if any("{y}" in line for line in getattr(machine.words, name)):
            yield f"words.{name}", "no {y} where coper.y is fixed"
    for k, axis in enumerate(machine.axes):
        if axis.moves == "Y":
            yield f"axes.{k}.moves", "no such axis where coper.y is fixed"


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
                yield f"axes.{k}.{end}", f"{least:g} to {most:.4g} at least, for {what}"


def _row_faults(key: str, row: TorchRow, coper: Coper) -> Iterator[Fault]:
    """A row that no torch cuts by, or between which and a thinner one no feed lies."""
    if row.process != "cut":
        yield f"{key}.process", "cut, as a coper does nothing else"
    for name in ("kerf", "cut_height", "pierce_height", "pierce_s"):
        if not getattr(row, name):
            yield f"{key}.{name}", "a figure above 0, as the torch goes round the steel by it"
    if row.cut_height <= coper.play:
        yield f"{key}.cut_height", f"more than play, {coper.play:g} mm"
    if row.pierce_height < row.cut_height:
        yield f"{key}.pierce_height", "at least cut_height"
    if row.passes != 1:
        yield f"{key}.passes", "1, as a torch cuts through at once"
    if coper.corner_radius < row.kerf / 2:
        expected = f"at least {row.kerf / 2:g}, half the kerf of the widest row"
        yield "coper.corner_radius", expected
    if coper.lead < row.pierce_radius:
        yield "coper.lead", f"at least {row.pierce_radius:g}, what piercing burns"
    if coper.trim < 2 * (coper.lead + row.kerf):
        yield "coper.trim", f"at least {2 * (coper.lead + row.kerf):g}, for leads and kerfs"
    thinner = (o for o in coper.rows if o.material == row.material and o.up_to < row.up_to)
    if coper.between_rows == "interpolate" and any(
        other.feed_mm_min <= row.feed_mm_min for other in thinner
    ):
        expected = "a feed below those of thinner steel, as between_rows is interpolate"
        yield f"{key}.feed_mm_min", expected
