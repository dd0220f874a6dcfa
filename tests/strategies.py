"""Random parts that a saw and drilling line can make."""

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


@st.composite
def holes(draw: st.DrawFn, profile: Profile, length: float) -> Hole:
    face = draw(st.sampled_from(("v", "o", "u")))
    width = profile.face_width(face)
    x = draw(st.one_of(st.sampled_from((100.0, 200.0, length - 100)), tenths(20, length - 20)))
    y = draw(st.one_of(st.sampled_from((40.0, width - 35)), tenths(30, width - 30)))
    return Hole(face, x, y, draw(st.sampled_from(DIAMETERS)), SOURCE)


@st.composite
def parts(draw: st.DrawFn, profile: Profile | None = None, most_holes: int = 12) -> Part:
    """A part with holes on web and flanges and with square or skew ends."""
    section = profile or draw(st.sampled_from((CHANNEL, BEAM)))
    length = draw(tenths(1300, 9000))
    angles = st.sampled_from((0.0, 0.0, 5.0, -20.0, 30.0, 44.9))
    drilled = draw(st.lists(holes(section, length), max_size=most_holes))
    # The same hole twice on one face is another matter, with a rule of its own.
    unique = {(h.face, h.x, h.y): h for h in drilled}
    return Part(
        "R1",
        section,
        length,
        SOURCE,
        cuts=EndCuts(draw(angles), draw(angles)),
        features=tuple(unique.values()),
    )


@st.composite
def bars(draw: st.DrawFn) -> list[Part]:
    """Parts of one section, to be laid on one bar."""
    section = draw(st.sampled_from((CHANNEL, BEAM)))
    return draw(st.lists(parts(section), min_size=1, max_size=4))
