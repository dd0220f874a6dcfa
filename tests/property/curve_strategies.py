"""Random curves for the laws of this folder."""

from math import cos, radians, sin

from hypothesis import strategies as st

from beamcam.geometry.curves import Arc, Bezier, BSpline, EllipseArc, Line, NewtonCurve

coordinates = st.floats(-500, 500).map(lambda v: round(v, 3))
points = st.tuples(coordinates, coordinates)
angles = st.one_of(
    st.sampled_from([0.0, 30.0, 90.0, 180.0, 270.0, -90.0]),
    st.floats(-720, 720).map(lambda v: round(v, 4)),
)
sweeps = st.one_of(
    st.sampled_from([360.0, -360.0, 90.0, -180.0]),
    st.floats(1, 360).map(lambda v: round(v, 4)),
    st.floats(-360, -1).map(lambda v: round(v, 4)),
)
radii = st.floats(0.5, 2000).map(lambda v: round(v, 3))


@st.composite
def lines(draw):
    start = draw(points)
    return Line(start, draw(points.filter(lambda p: p != start)))


arcs = st.builds(Arc, points, radii, angles, sweeps)


@st.composite
def ellipses(draw):
    turn, size = radians(draw(angles)), draw(radii)
    axis = (size * cos(turn), size * sin(turn))
    return EllipseArc(draw(points), axis, draw(st.floats(0.05, 1)), draw(angles), draw(sweeps))


weights = st.floats(0.2, 5)


@st.composite
def beziers(draw):
    chain = draw(st.lists(points, min_size=2, max_size=6, unique=True))
    w = tuple(draw(weights) for _ in chain) if draw(st.booleans()) else None
    return Bezier(tuple(chain), w)


@st.composite
def splines(draw):
    degree = draw(st.integers(1, 4))
    count = degree + 1 + draw(st.integers(0, 5))
    control = tuple(draw(st.lists(points, min_size=count, max_size=count, unique=True)))
    gaps = draw(st.lists(st.integers(1, 4), min_size=count + degree, max_size=count + degree))
    knots = [0.0]
    for gap in gaps:
        knots.append(knots[-1] + gap)
    if draw(st.booleans()):
        knots[: degree + 1] = [knots[degree]] * (degree + 1)
        knots[count:] = [knots[count]] * (degree + 1)
    w = tuple(draw(weights) for _ in control) if draw(st.booleans()) else None
    return BSpline(degree, control, tuple(knots), w)


@st.composite
def newton_curves(draw):
    count = draw(st.integers(2, 5))
    if draw(st.booleans()):
        steps = draw(st.lists(st.integers(5, 60), min_size=count, max_size=count))
        side = draw(st.sampled_from([1, -1]))
        xs = [side * sum(steps[: k + 1]) for k in range(count)]
        return NewtonCurve(tuple((float(x), draw(st.integers(-80, 80)) * 1.0) for x in xs))
    chain = draw(st.lists(points, min_size=count, max_size=count, unique=True))
    return NewtonCurve(tuple(chain))


curves = st.one_of(lines(), arcs, ellipses(), beziers(), splines(), newton_curves())


@st.composite
def regular_matrices(draw):
    """Affine maps that do not flatten the plane; every third a similarity."""
    turn, scale = radians(draw(angles)), draw(st.floats(0.1, 10))
    c, s, mirror = scale * cos(turn), scale * sin(turn), draw(st.sampled_from([1.0, -1.0]))
    stretch, skew = 1.0, 0.0
    if draw(st.integers(0, 2)):
        stretch, skew = draw(st.floats(0.2, 5)), draw(st.floats(-2, 2))
    shift = draw(points)
    return (
        (c, -mirror * s * stretch + c * skew, shift[0]),
        (s, mirror * c * stretch + s * skew, shift[1]),
    )
