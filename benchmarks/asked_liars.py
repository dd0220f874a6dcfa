"""A planner that makes another job than was asked for: pieces and layouts of its own.

Of each request pieces are dropped, doubled, exchanged and put in another order, bars are taken that
are not in store, and the parts of a sheet are laid mirrored, turned, copied and spaced otherwise,
or with a feature too few. Each job is begun and posted as any other, and all have to be refused.
"""

from collections import Counter
from collections.abc import Callable, Iterator
from unittest.mock import patch

from msgspec.structs import replace

from beamcam import pipeline
from beamcam.errors import PlanError, Source, VerifyError
from beamcam.geometry.curves import Arc, Line
from beamcam.machine import load
from beamcam.machine.overlay import with_torch
from beamcam.machine.torch import Torch
from beamcam.model.part import Contour, Hole, Part, Profile, Slot
from beamcam.model.request import Request, Share
from beamcam.planning.contours import plate
from benchmarks.liars import Lies

S = Source("asked.nc1", 1)
Shares = tuple[Share, ...]
CHANNEL = Profile("U", "UPN200", 200.0, 75.0, 11.5, 8.5, 11.5)
LAYOUTS: tuple[dict[str, object], ...] = (
    {"mirror": "x"}, {"mirror": "y", "copies": (2, 1)}, {"rotate": 30.0},
    {"rotate": 90.0, "copies": (2, 2)}, {"mirror": "x", "rotate": -45.0, "copies": (3, 1)},
)  # fmt: skip


def bars() -> tuple[Part, ...]:
    """Two marks of one section, of which the second is wanted three times."""
    return tuple(
        Part(mark, CHANNEL, length, Source(f"{mark}.nc1", 1), count,
             features=(Hole("v", at, 100.0, 18.0, S),))
        for mark, length, count, at in (("A", 2500.0, 2, 600.0), ("B", 3100.0, 3, 900.0))
    )  # fmt: skip


def plates() -> tuple[Part, ...]:
    """An L-shaped plate, which is not its own mirror image, and a round one."""
    corners = [(0, 0), (300, 0), (300, 80), (120, 80), (120, 200), (0, 200)]
    sides = tuple(map(Line, corners, [*corners[1:], corners[0]]))
    bent = (
        Contour("v", "outer", sides, S), Hole("v", 40.0, 30.0, 22.0, S),
        Slot("v", 200.0, 40.0, 20.0, 30.0, 0.0, 25.0, S),
    )  # fmt: skip
    ring = (Contour("v", "outer", (Arc((100.0, 100.0), 100.0, 0.0, 360.0),), S),)
    profile = Profile("B", "PL10", 200.0, 0.0, 0.0, 10.0)
    return (
        Part("L1", profile, 300.0, Source("l.nc1", 1), 2, features=bent),
        Part("R1", profile, 200.0, Source("r.nc1", 1), 3, features=ring),
    )


def shared_otherwise(shares: Shares) -> Iterator[tuple[str, Shares]]:
    """False shares of a request's pieces."""
    yield "a program is dropped", shares[:-1]
    yield "a program is made twice", (*shares, shares[-1])
    for k, share in enumerate(shares):
        pieces = share.pieces
        others = lambda to, k=k: (*shares[:k], to, *shares[k + 1 :])  # noqa: E731
        yield "the last piece is dropped", others(replace(share, pieces=pieces[:-1]))
        yield "the first piece is dropped", others(replace(share, pieces=pieces[1:]))
        yield "a piece is made twice", others(replace(share, pieces=(*pieces, pieces[-1])))
        if len(set(pieces)) > 1:
            yield "pieces in another order", others(replace(share, pieces=pieces[::-1]))
        for place, other in enumerate(pieces):
            exchanged = (*pieces[:place], 1 - other, *pieces[place + 1 :])
            yield "a piece of the other part", others(replace(share, pieces=exchanged))
        if share.lengths:
            yield "a bar that is not in store", others(replace(share, lengths=(11000.0,)))


def laid_otherwise(torch: Torch) -> Iterator[tuple[str, Callable[[Part, Torch], Part]]]:
    """False layouts in place of `plate.laid_out`, by what is wrong with them."""
    true = plate.laid_out
    columns, rows = torch.copies
    turns = {"none": ("x", "y"), "x": ("none", "y"), "y": ("none", "x")}
    others: list[tuple[str, dict[str, object]]] = [
        *(("mirrored otherwise", {"mirror": other}) for other in turns[torch.mirror]),
        ("turned further", {"rotate": torch.rotate + 1.0}),
        ("turned by 180", {"rotate": torch.rotate + 180.0}),
        ("a column more", {"copies": (columns + 1, rows)}),
        ("a row more", {"copies": (columns, rows + 1)}),
    ]
    if torch.rotate:
        others.append(("turned the other way", {"rotate": -torch.rotate}))
    if columns > 1:
        others.append(("a column less", {"copies": (columns - 1, rows)}))
    if columns * rows > 1:
        others.append(("spaced otherwise", {"spacing": torch.spacing + 1.0}))
    for name, values in others:
        false = replace(torch, **values)  # type: ignore[arg-type]
        yield name, lambda part, _, false=false: true(part, false)
    for index in range(3):

        def lacking(part: Part, asked: Torch, index: int = index) -> Part:
            found = true(part, asked)
            kept = [f for k, f in enumerate(found.features) if k != index % len(found.features)]
            return replace(found, features=tuple(kept))

        yield "a feature is lost", lacking


def told() -> Lies:
    """All lies about quantity and layout, and which of them the pipeline refuses."""
    result = Lies(Counter(), Counter(), [])
    line = load("beamline")
    table = with_torch(load("plate-linuxcnc"), sheet_size=(700.0, 450.0))
    for request in (
        Request(bars(), line, stock=(6000.0, 12000.0), quantity="file"),
        Request(bars(), line, stock=(12000.0,), quantity=2),
        Request(bars(), line, stock=(6000.0,)),
        Request(plates(), table, quantity="file"),
        Request(plates(), table, quantity=3),
    ):
        shares = pipeline.shares_of(request)
        _post(request)
        for lie, false in shared_otherwise(shares):
            with patch.object(pipeline, "shares_of", lambda *_, false=false: false):
                _tell(result, request.machine.name, lie, request)
    large = with_torch(load("plate-linuxcnc"), sheet_size=(3000.0, 1500.0), place="corner")
    for asked in LAYOUTS:
        machine = with_torch(large, **asked, spacing=20.0)  # type: ignore[arg-type]
        request = Request(plates()[:1], machine)
        assert machine.torch is not None
        truth = _post(request)
        for lie, laid_out in laid_otherwise(machine.torch):
            with patch.object(plate, "laid_out", laid_out):
                if _text_of(request) != truth:
                    _tell(result, f"{machine.name} {asked}", lie, request)
    return result


def _post(request: Request) -> list[str]:
    return [pipeline.finished(begun).text for begun in pipeline.begin(request)]


def _text_of(request: Request) -> list[str]:
    try:
        return _post(replace(request, verified=False))
    except PlanError:
        return []


def _tell(result: Lies, where: str, lie: str, request: Request) -> None:
    result.made[lie] += 1
    try:
        _post(request)
    except VerifyError:
        result.caught[lie] += 1
    except PlanError as error:
        # A planner whose lie does not fit its own machine posts nothing either.
        if not all(said.code.startswith("plan-") for said in error.diagnostics):
            raise
        result.caught[lie] += 1
    else:
        result.missed.append((where, lie))
