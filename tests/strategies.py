"""Random parts that a saw and drilling line can make."""

from math import ceil, hypot, radians, tan

from hypothesis import strategies as st

from beamcam.errors import Source
from beamcam.model.part import EndCuts, Hole, Part, Profile

CHANNEL = Profile("U", "UPN200", 200.0, 75.0, 11.5, 8.5, 11.5)
BEAM = Profile("I", "IPE300", 300.0, 150.0, 10.7, 7.1, 15.0)
DIAMETERS = (11.0, 13.0, 14.0, 18.0, 22.0, 26.0)
SOURCE = Source("random.nc1", 1)


def tenths(least: float, greatest: float) -> st.SearchStrategy[float]:
    """Lengths to a tenth of a millimetre, as detailers give them, so that some coincide."""
    return st.integers(round(least * 10), round(greatest * 10)).map(lambda n: n / 10)


#: Lines across a face that are clear of walls and fillets for every diameter.
GAUGES = {
    (profile.code, face): lines
    for profile, flange in ((CHANNEL, (40.0, 45.0)), (BEAM, (40.0, 35.0, 110.0, 115.0)))
    for face, lines in (("v", (45.0, profile.height - 45.0)), ("o", flange), ("u", flange))
}
CLEAR = 5.0  #: mm of steel between holes, and between a hole and an end


@st.composite
def holes(draw: st.DrawFn, profile: Profile, start: float, end: float) -> Hole:
    """A hole whose middle lies between two x, clear of the other walls of its section."""
    face = draw(st.sampled_from(("v", "o", "u")))
    lines = GAUGES[profile.code, face]
    y = draw(st.sampled_from(lines) | tenths(*lines) if face == "v" else st.sampled_from(lines))
    x = draw(st.sampled_from((start, start + 100.0, end)) | tenths(start, end))
    return Hole(face, x, y, draw(st.sampled_from(DIAMETERS)), SOURCE)


def apart(drilled: list[Hole]) -> tuple[Hole, ...]:
    """The holes but for those that come too near to one before."""
    kept: list[Hole] = []
    for hole in drilled:
        if all(
            hole.face != other.face
            or hypot(hole.x - other.x, hole.y - other.y)
            >= (hole.diameter + other.diameter) / 2 + CLEAR
            for other in kept
        ):
            kept.append(hole)
    return tuple(kept)


@st.composite
def parts(draw: st.DrawFn, profile: Profile | None = None, most_holes: int = 12) -> Part:
    """A part with square or skew ends, and with holes on web and flanges between them."""
    section = profile or draw(st.sampled_from((CHANNEL, BEAM)))
    length = draw(tenths(1300, 4000))
    angles = st.sampled_from((0.0, 0.0, 5.0, -20.0, 30.0, 44.9))
    first, last = draw(angles), draw(angles)
    # A skew end takes this much off the longest edge; the hole's radius and some steel follow.
    start, end = (
        ceil(section.height * tan(radians(abs(angle))) + max(DIAMETERS) + CLEAR)
        for angle in (first, last)
    )
    drilled = draw(st.lists(holes(section, start, length - end), max_size=most_holes))
    cuts = EndCuts(first, last)
    return Part("R1", section, length, SOURCE, cuts=cuts, features=apart(drilled))


@st.composite
def bars(draw: st.DrawFn) -> list[Part]:
    """Parts of one section, to be laid on one bar."""
    section = draw(st.sampled_from((CHANNEL, BEAM)))
    return draw(st.lists(parts(section), min_size=1, max_size=4))
