"""Does the rest of the file agree with what was read of a member?"""

from math import hypot

from beamcam.errors import Diagnostic, Source
from beamcam.model.part import Contour, Hole, Part, Slot
from beamcam.readers.ifc import kernel, rules
from beamcam.readers.ifc.entities import Entity, Model, Unreadable
from beamcam.readers.ifc.finish import Shaped
from beamcam.readers.ifc.marks import LENGTHS, WEIGHTS, Data
from beamcam.readers.ifc.shell import extent
from beamcam.readers.ifc.slices import hollows
from beamcam.readers.ifc.walls import Wall, walls_of

STEEL = 7.85e-6  #: kg/mm3
LENGTH_SLACK = 1.0  #: mm; property sets are rounded
WEIGHT_SLACK = 0.06  #: share; of 177 real members all but two are within 0.03
SMALL_WEIGHT = 0.1  #: kg below which a rounded weight says nothing
VOLUME_SLACK = 0.03  #: share between two ways of building a member


def check_data(part: Part, shaped: Shaped, data: Data, source: Source) -> tuple[Diagnostic, ...]:
    """Where the length or the weight in the property sets denies the geometry."""
    said = []
    length = data.number(*LENGTHS)
    if length is not None:
        where, value = length
        extents = [part.length, shaped.gross, part.profile.height, part.profile.width]
        if part.profile.code == "B":
            extents.append(hypot(part.length, part.profile.height))
        if all(abs(value - e) > LENGTH_SLACK for e in extents) and part.profile.code != "B":
            said.append(
                rules.LENGTH.at(
                    source, found=f"{value:.2f}", where=where, expected=f"{part.length:.2f}"
                )
            )
    weight = data.number(*WEIGHTS)
    if weight is not None and weight[1] > SMALL_WEIGHT:
        where, value = weight
        gross = shaped.section.area * shaped.gross
        expected = [v * STEEL for v in (shaped.volume, gross)]
        if all(abs(value - e) > WEIGHT_SLACK * e + SMALL_WEIGHT for e in expected):
            said.append(
                rules.WEIGHT.at(
                    source, found=f"{value:.2f}", where=where, expected=f"{expected[0]:.2f}"
                )
            )
    return tuple(said)


def check_kernel(
    model: Model, element: Entity, part: Part, shaped: Shaped, data: Data
) -> tuple[Diagnostic, ...]:
    """Where the kernel's solid has other holes, another length or another volume."""
    try:
        built = kernel.build(model, element)
    except Unreadable as reason:
        return _denied(part, shaped, data, f"no solid ({reason})", "a solid")
    errors = [line for line in built.log if "[error]" in line.lower()]
    if errors:
        return (rules.KERNEL_LOG.at(part.source, found=errors[0][:160]),)
    volume = built.shell.volume
    if volume is not None and abs(volume - shaped.volume) > VOLUME_SLACK * max(
        volume, shaped.volume
    ):
        return _denied(
            part,
            shaped,
            data,
            f"a volume of {volume / 1e3:.1f} cm3",
            f"{shaped.volume / 1e3:.1f} cm3",
        )
    local = built.shell.moved(shaped.frame.inverse())
    low, high = extent(local, (1.0, 0.0, 0.0))
    if abs(high - low - part.length) > 0.1:
        return _denied(
            part, shaped, data, f"a length of {high - low:.2f} mm", f"{part.length:.2f} mm"
        )
    for wall in walls_of(shaped.section):
        found = hollows(local.raw_slice(wall, (wall.low + wall.high) / 2))
        expected = sum(_through(f, wall) for f in part.features)
        if found != expected:
            return _denied(part, shaped, data, f"{found} holes in face {wall.face}", str(expected))
    return ()


def _through(feature: object, wall: Wall) -> bool:
    """Whether a feature is a hollow of a wall's middle plane."""
    if isinstance(feature, Contour):
        return feature.face == wall.face and feature.kind == "inner"
    if not isinstance(feature, (Hole, Slot)):
        return False
    if feature.depth is not None and feature.depth < wall.thickness / 2:
        return False
    return feature.face == wall.face or (
        feature.face == "h" and wall.face == "v" and feature.depth is not None
    )


def _denied(
    part: Part, shaped: Shaped, data: Data, found: str, expected: str
) -> tuple[Diagnostic, ...]:
    """A contradiction; the file's net weight decides it where there is one."""
    weight = data.number(*WEIGHTS)
    own = shaped.volume * STEEL
    if weight is not None and abs(weight[1] - own) <= VOLUME_SLACK * own:
        said = rules.KERNEL_DENIED.at(
            part.source, found=found, expected=expected, witness=weight[0]
        )
        return (said,)
    return (rules.KERNEL.at(part.source, found=found, expected=expected),)
