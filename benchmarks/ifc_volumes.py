"""Members of many families, each as solid and as mesh: is any read as another one without a word?

    python benchmarks/ifc_volumes.py [SEEDS] [--family NAME ...] [--first N] [--verbose]

Each part that was read is built again by the geometry kernel from its own numbers and measured
beside the member that went in. Printed is what became of how many; a member that differs by more
than 0.1 cm3 without an error or a warning is named, and the exit status is 1 then.

The families of tests/property/ifc_cut_families.py are written plainly. Those of ifc_families.py are
slots, notched plates, tubes, channels with lips, angles of two thicknesses and other sections;
`anyhow` writes the first ones with openings as elements, mapped items, turned placements, in inches
and in metres (ifc_anyhow.py).
"""

import sys
from collections import Counter
from math import acos, cos, hypot, radians, sin, tan
from pathlib import Path
from random import Random

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))


from beamcam.errors import Severity  # noqa: E402
from beamcam.model.part import Part  # noqa: E402
from beamcam.readers import Reading  # noqa: E402
from beamcam.readers.ifc import Options, read  # noqa: E402
from benchmarks.ifc_anyhow import written_anyhow  # noqa: E402
from benchmarks.ifc_families import (  # noqa: E402
    angles,
    kinked,
    lipped,
    plates,
    round_holes,
    slotted,
    special,
)
from benchmarks.script import arguments, at_least, start  # noqa: E402
from tests.property.ifc_cut_families import FAMILIES  # noqa: E402
from tests.property.ifc_cuts import Bar, Cuts, Half, model_of  # noqa: E402
from tests.property.ifc_kernel import kernel_volume, meshed, same, volumes  # noqa: E402
from tests.property.ifc_remade import remade, shape_of  # noqa: E402

CHECKED = Options(kernel=True)


def plain(name: str) -> object:
    def made(random: Random) -> tuple[Bar, bytes]:
        bar, cutters = FAMILIES[name](random)
        return bar, model_of(bar, cutters)

    return made


MORE = {
    "slotted": slotted, "plates": plates, "special": special, "kinked": kinked,
    "round_holes": round_holes, "lipped": lipped, "angles": angles, "anyhow": written_anyhow,
}  # fmt: skip


def rebuilt(part: Part, bar: Bar) -> bytes:
    """A model of what was read."""
    if part.section:
        return outlined_again(part)
    made, body = remade(part, shape_of(part, bar))
    made.small.element(body)
    return made.small.data


def outlined_again(part: Part) -> bytes:
    """A special section has its outline, its length and its end cuts, and nothing else."""
    made = Cuts()
    points = ring_of(part)
    whole = Bar("SO", part.length, (part.profile.height, part.profile.width, 0.0, 0.0, 0.0))
    taken: list[str] = []
    c = part.cuts
    for side, web, flange in ((-1, c.web_start, c.flange_start), (1, c.web_end, c.flange_end)):
        slope, lean = -tan(radians(web)), -tan(radians(flange))
        if web or flange:
            h, b = part.profile.height, part.profile.width
            reach = [slope * y + lean * z for y in (0.0, h) for z in (0.0, b)]
            x = part.length - max(reach) if side > 0 else -min(reach)
            taken.append(
                made.cutter(whole, Half((x, 0.0, 0.0), (side, -side * slope, -side * lean)))
            )
    profile = made.small.polygon(*(tuple(made.point(whole, (0.0, y, z))[1:]) for y, z in points))
    body = made.small.minus(made.small.extruded(profile, part.length), *taken)
    made.small.element(body)
    return made.small.data


def ring_of(part: Part) -> list[tuple[float, float]]:
    """The outline of a special section in (Y, Z), its arcs in steps of a degree."""
    out: list[tuple[float, float]] = []
    points = part.section
    for a, b in zip(points, (*points[1:], points[0]), strict=True):
        out.append((a.y, a.z))
        if not a.radius:
            continue
        r, dy, dz = abs(a.radius), b.y - a.y, b.z - a.z
        chord = hypot(dy, dz)
        turn = acos(max(-1.0, 1 - chord * chord / (2 * r * r)))
        sense = -1.0 if a.radius > 0 else 1.0
        # The centre lies to one side of the chord; the arc bulges to the other.
        off = (r * r - chord * chord / 4) ** 0.5 * sense
        cy, cz = (a.y + b.y) / 2 + off * dz / chord, (a.z + b.z) / 2 - off * dy / chord
        for k in range(1, 90):
            t = sense * turn * k / 90
            u, v = a.y - cy, a.z - cz
            out.append((cy + u * cos(t) + v * sin(t), cz - u * sin(t) + v * cos(t)))
    return out


def outcome(bar: Bar, data: bytes, written: bytes, reading: Reading) -> str:
    """What became of a member: read, told with a word, refused; or silently another one.

    `written` is its mesh, if that was read, whose chords may leave less than `data` has.
    """
    said = sorted({d.code for d in reading.diagnostics if d.severity is not Severity.NOTE})
    if not reading.parts:
        return "refused " + ",".join(said) if said else "SILENTLY left out"
    if said:
        return "told " + ",".join(said)
    (part,) = reading.parts
    again = rebuilt(part, bar)
    pairs = [pair for one in (data, written) if (pair := volumes(one, again)) is not None]
    if not pairs:
        return "not measured"
    if any(same(*pair) for pair in pairs):
        return "read"
    return f"SILENTLY {pairs[0][1] - pairs[0][0]:+.3f} of {pairs[0][0]:.2f} cm3"


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("seeds", nargs="?", type=at_least(1), default=100, help="default 100")
    parser.add_argument("--family", action="append", choices=[*FAMILIES, *MORE], default=[])
    parser.add_argument("--first", type=at_least(0), default=0, help="the first seed")
    parser.add_argument("--verbose", action="store_true", help="name refused ones as well")
    asked = parser.parse_args()
    families = {**{name: plain(name) for name in FAMILIES}, **MORE}
    silent = 0
    for name in asked.family or families:
        for mesh in (False, True):
            rows: Counter[str] = Counter()
            lines = []
            for seed in range(asked.first, asked.first + asked.seeds):
                bar, data = families[name](Random(f"{name}{seed}"))  # type: ignore[operator]
                if not kernel_volume(data):
                    rows["no solid"] += 1
                    continue
                written = meshed(data) if mesh else data
                reading = read(written, "m.ifc", options=CHECKED)
                row = outcome(bar, data, written, reading)
                rows["SILENT" if "SILENTLY" in row else row] += 1
                silent += "SILENTLY" in row
                if "SILENTLY" in row or (asked.verbose and "refused" in row):
                    lines.append(f"    {seed}: {row} {_first(reading)}")
            print(name, "meshes" if mesh else "solids", dict(rows.most_common()))
            print(*lines, sep="\n", end="\n" if lines else "")
    sys.exit(1 if silent else 0)


def _first(reading: Reading) -> str:
    return next((d.message for d in reading.diagnostics if d.severity is Severity.ERROR), "")


if __name__ == "__main__":
    start(main)
