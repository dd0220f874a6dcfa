"""Random parts that a DSTV file can hold, for the laws of this folder."""

import string
from itertools import pairwise
from math import hypot

from hypothesis import assume
from hypothesis import strategies as st

from beamcam.errors import Source
from beamcam.geometry.curves import Line, arc_through, signed_area, unit_vector
from beamcam.model.anchors import anchor_key, plane_positions
from beamcam.model.part import (
    MIRRORED_FACES,
    PROFILE_CODES,
    Bend,
    Bevel,
    Camber,
    Contour,
    EndCuts,
    EndPlane,
    FileComment,
    Hole,
    Notch,
    Part,
    Plane,
    Profile,
    SectionPoint,
    Slot,
    TextMark,
)

HERE = Source("random.nc1", 1)

#: Numbers as files have them: two decimals, now and then more.
numbers = st.one_of(
    st.integers(-50_000, 500_000).map(lambda v: v / 100),
    st.integers(-9_000_000, 9_000_000).map(lambda v: v / 1_000_000),
)
sizes = st.integers(0, 60_000).map(lambda v: v / 100)
lengths = st.integers(1, 2_000_000).map(lambda v: v / 100)
angles = st.integers(-18_000, 18_000).map(lambda v: v / 100)
cut_angles = st.integers(-8_999, 8_999).map(lambda v: v / 100)
points = st.tuples(numbers, numbers)
vectors = st.tuples(numbers, numbers, numbers)
edges = st.sampled_from(["", "u", "o", "s"])

_LETTERS = string.ascii_letters + string.digits + " .,:;*#/+-_äé"
texts = st.text(_LETTERS, max_size=20).map(str.strip)
words = texts.filter(lambda t: t and not t.startswith("**"))
header_texts = texts.filter(lambda t: t != "-" and not t.startswith("**"))
comment_texts = st.text(_LETTERS, max_size=20).map(str.rstrip)


@st.composite
def holes(draw, face):
    kind = draw(
        st.sampled_from(["through", "blind", "thread", "left-thread", "countersink", "mark"])
    )
    diameter = draw(sizes if kind == "mark" else lengths)
    depth = draw(lengths) if kind == "blind" else None
    if kind in ("thread", "left-thread", "countersink"):
        depth = draw(st.none() | lengths)
    cone = draw(st.none() | lengths) if kind == "countersink" else None
    return Hole(face, draw(numbers), draw(numbers), diameter, HERE, depth, kind, cone, draw(edges))


@st.composite
def slots(draw, face):
    x, y = draw(points)
    length, height = draw(st.tuples(sizes, sizes).filter(any))
    angle = draw(st.one_of(st.sampled_from([0.0, 90.0, 180.0]), angles))
    cos_w, sin_w = unit_vector(angle)
    x += (length * cos_w - height * sin_w) / 2
    y += (length * sin_w + height * cos_w) / 2
    depth = draw(st.none() | lengths)
    kind = "through" if depth is None else "blind"
    return Slot(face, x, y, draw(sizes), length, height, angle, HERE, depth, kind, draw(edges))


@st.composite
def contours(draw, face):
    kind, process = draw(
        st.sampled_from(
            [
                ("outer", "cut"),
                ("inner", "cut"),
                ("open", "punch"),
                ("open", "powder"),
                ("inner", "punch"),
                ("inner", "powder"),
            ]
        )
    )
    closed = kind != "open"
    corners = draw(st.lists(points, min_size=2, max_size=7, unique=True))
    if closed:
        corners = [*corners, corners[0]]
    curves = []
    for start, end in pairwise(corners):
        chord = hypot(end[0] - start[0], end[1] - start[1])
        factor = draw(st.sampled_from([None, None, 1.0, 1.3, 5.0]))
        if factor is None or chord < 0.1:
            curves.append(Line(start, end))
        else:
            # what is nearer to a half circle is written as two arcs
            radius = round(chord / 2 * factor + 0.04, 2)
            curves.append(arc_through(start, end, draw(st.sampled_from([radius, -radius]))))
    if closed:
        area = signed_area(tuple(curves))
        assume(abs(area) > 1)
        if (area > 0) != ((kind == "outer") != (face in MIRRORED_FACES)):
            # as arcs of their own ends again, so that they come back to the last bit
            curves = [
                Line(c.end, c.start)
                if isinstance(c, Line)
                else arc_through(b, a, -c.radius if c.sweep_deg > 0 else c.radius)
                for c, (a, b) in zip(curves, pairwise(corners), strict=True)
            ][::-1]
    count = len(curves)
    places = st.integers(0, count - 1)
    pair = st.tuples(angles.filter(bool), lengths)
    bevels = [
        Bevel(curve, angle, land)
        for curve in sorted(draw(st.sets(places, max_size=2)))
        for angle, land in draw(st.lists(pair, min_size=1, max_size=2))
    ]
    notches = [
        Notch(
            curve,
            draw(st.sampled_from("tw")),
            tuple(round(v, 6) + 0.0 for v in curves[curve].start),
            draw(st.integers(-2000, 2000)) / 100,
        )
        for curve in sorted(draw(st.lists(places, max_size=2)))
    ]
    if kind == "open" and process == "punch":
        assume(curves[0].start != curves[-1].end)
    return Contour(
        face,
        kind,
        tuple(curves),
        HERE,
        process,
        closed,
        tuple(bevels),
        tuple(notches),
        draw(edges),
    )


@st.composite
def text_marks(draw, face):
    return TextMark(
        face,
        draw(numbers),
        draw(numbers),
        draw(angles),
        draw(st.one_of(st.integers(0, 99).map(float), st.sampled_from([7.5, 12.25]))),
        draw(words),
        HERE,
        draw(st.sampled_from(["", "r", "z"])),
        draw(edges),
    )


def features_on(face):
    return st.one_of(holes(face), slots(face), contours(face), text_marks(face))


@st.composite
def features_anywhere(draw):
    face = draw(st.sampled_from("vuoh"))
    other = st.one_of(
        st.builds(Bend, points, points, angles, st.none() | sizes, st.just(HERE)),
        st.builds(EndPlane, vectors, vectors.filter(any), st.just(HERE)),
        st.builds(Camber, st.just(face), numbers, numbers, st.just(HERE)),
    )
    return draw(st.one_of(features_on(face), features_on(face), other))


@st.composite
def planes_and_features(draw):
    """Planes, some of a number that was used before, and the features in an order that suits."""
    features = draw(st.lists(features_anywhere(), max_size=6))
    planes = []
    used: dict[str, int] = {}
    for digit in draw(st.lists(st.sampled_from("012"), max_size=3)):
        used[digit] = used.get(digit, 0) + 1
        name = f"E{digit}" if used[digit] == 1 else f"E{digit}#{used[digit]}"
        planes.append(Plane(name, draw(vectors), draw(vectors), draw(vectors), HERE))
        features += draw(st.lists(features_on(name), max_size=2))
    return tuple(planes), tuple(features)


@st.composite
def comments_of(draw, planes, features, part):
    """Comments at places that the part has, in the order in which they are written."""
    anchors = ["start", "end", "after-end", *(f"header:{n}" for n in (1, 2, 9, 21, 24))]
    things = [f"feature:{i}" for i in range(len(features))]
    things += [f"plane:{i}" for i in range(len(planes))]
    things += [f"section:{i}" for i in range(len(part.section))]
    things += [f"info:{i}" for i in range(len(part.info))]
    things += ["tolerance"] if part.tolerance else []
    anchors += things + ["block:" + thing for thing in things]
    for i, feature in enumerate(features):
        if isinstance(feature, Contour):
            rows = len(feature.curves) + 1 + len(feature.notches)
            anchors += [f"feature:{i}:{row}" for row in range(1, rows)]
    anchors += [f"plane:{i}:{row}" for i in range(len(planes)) for row in (1, 2)]
    chosen = draw(st.lists(st.sampled_from(anchors), max_size=4))
    positions = plane_positions(planes, features)
    chosen.sort(key=lambda anchor: anchor_key(anchor, positions))
    return tuple(FileComment(draw(comment_texts), anchor) for anchor in chosen)


@st.composite
def parts(draw):
    """A part that a DSTV file can hold to the last bit."""
    planes, features = draw(planes_and_features())
    profile = Profile(
        draw(st.sampled_from(PROFILE_CODES)),
        draw(header_texts),
        *(draw(sizes) for _ in range(5)),
    )
    info = st.one_of(
        st.tuples(words.filter(lambda t: ":" not in t), texts),
        st.tuples(st.just(""), words.filter(lambda t: ":" not in t and len(t) > 2)),
    )
    section_points = st.builds(SectionPoint, st.sampled_from("+-"), numbers, numbers, sizes)
    notes = draw(st.lists(header_texts, max_size=5))
    while notes and not notes[-1]:
        notes.pop()
    part = Part(
        draw(header_texts),
        profile,
        draw(lengths),
        HERE,
        draw(st.integers(0, 999)),
        draw(st.none() | lengths),
        draw(header_texts),
        draw(header_texts),
        draw(header_texts),
        draw(header_texts),
        EndCuts(*(draw(cut_angles) for _ in range(4))),
        features,
        planes,
        draw(sizes),
        draw(sizes),
        tuple(notes),
        draw(st.none() | st.tuples(numbers, numbers)),
        tuple(draw(st.lists(section_points, max_size=3))),
        tuple(draw(st.lists(info, max_size=2))),
    )
    comments = draw(comments_of(planes, features, part))
    return Part(**{**{n: getattr(part, n) for n in part.__slots__}, "comments": comments})
