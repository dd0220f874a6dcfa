"""The interface of a kind of work on a bar.

Each is a module of this package that ends with its `Kind`, and a row of `kinds.KINDS`. Messages
that are errors refuse a feature, by the first of them; it may then be left out if its code is
allowed by name.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any

from msgspec import Struct

from beamcam.errors import Diagnostic
from beamcam.machine.machine import Machine
from beamcam.model.part import Feature
from beamcam.model.plan import Plan, WorkOp
from beamcam.planning.operations.bench import Bench
from beamcam.planning.operations.working_step import Found

Numbered = tuple[int, Any]  #: index of a feature, and the feature


def nothing(*_: Any) -> Iterator[Any]:
    """Of a kind that has nothing to say."""
    return iter(())


class Kind(Struct, frozen=True):
    """One kind of work."""

    name: str
    makes: Callable[[Feature], bool]  #: whether a feature is of this kind
    #: What the machine lacks for a feature; None if it has everything.
    needs: Callable[[Any, Bench], Diagnostic | None]
    #: What is wrong with the place of a feature on the finished part, or odd.
    refusals: Callable[[Any, Bench], Iterable[Diagnostic]] = nothing
    #: The steps of all its features of a part together.
    steps: Callable[[Sequence[Numbered], Bench], Iterable[Found]] = nothing
    reasons: Mapping[str, str] = {}  #: explanations of its steps: stable code and text
    #: What might have been done instead of an operation, and why it was not.
    rejected: Callable[[WorkOp, Plan, Machine], Iterator[str]] = nothing
