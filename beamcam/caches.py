"""All caches, by name, each with its bound and its reason.

No other module keeps anything between two calls. A cache holds what follows from its key alone, so
that it makes no difference to any result; all of them may be used by several threads at once.
"""

from collections.abc import Callable, Hashable
from functools import lru_cache
from operator import is_
from threading import Lock
from typing import Generic, ParamSpec, TypeVar, cast

from msgspec import Struct

Asked = ParamSpec("Asked")
Value = TypeVar("Value")
Key = TypeVar("Key", bound=Hashable)
Other = TypeVar("Other", bound=Hashable)


class Bound(Struct, frozen=True):
    """Bound of a cache, and the reason for it."""

    max_entries: int
    reason: str


#: Sections, tools and strokes that are met again in the parts of one building.
_OF_A_BUILDING = "the parts of a job repeat it; without it posting takes a half longer"
CACHES = {
    "files.machine": Bound(32, "checking a machine file takes 10 ms, posting a part takes 1"),
    "files.toml": Bound(32, "the text of a machine file is parsed once, however often it is named"),
    "files.lines": Bound(4, "messages and `machines show` ask for the line of each key"),
    "machine.formula": Bound(1024, "a formula of a machine file is compiled once, used per stroke"),
    "machine.words": Bound(16, "the words of a machine are tried once, half a millisecond"),
    "machine.proof": Bound(16, "a machine file is proved by a part once, some milliseconds"),
    "machine.post": Bound(16, "the modules of a kind of machine are imported once"),
    "readers.module": Bound(16, "the module of a format is imported once"),
    "batch.shop": Bound(4, "a worker thaws its machines once, so that what is known of them stays"),
    "sections.table": Bound(1, "a table of 1,300 sections is read from its file"),
    "sections.name": Bound(4096, "each member of a model asks for the name of its section"),
    "dstv.sections": Bound(256, "the parts of a job share sections; all asks of one hash it once"),
    "ifc.parser": Bound(1, "ifcopenshell is loaded where a model is opened"),
    "ifc.identifier": Bound(4, "each class that is met asks for the name of its schema"),
    "ifc.class": Bound(2048, "the entities of a model share their classes"),
    "ifc.kernel": Bound(1, "ifcopenshell is loaded where a solid has to be built, 300 ms"),
    "ifc.section_name": Bound(4096, "the members of a model share the texts that name sections"),
    "ifc.said_measures": Bound(4096, "the members of a model share the names of their sections"),
    "ifc.spread": Bound(4096, "the holes of a model share size and axes"),
    "ifc.walls": Bound(4096, "each face of a member asks for the walls of its section"),
    "ifc.corners": Bound(4096, "each end of a member asks for the corners of its section"),
    "drawings.looks": Bound(1024, "the lines of a drawing have few layers and colours"),
    "svg.decimals": Bound(64, "a pattern for each number of decimals, of which few are met"),
    "curves.table": Bound(3, "reader, planner, motion and read-back ask for the same curves"),
    "curves.newton": Bound(256, "divided differences take n^2 steps, each point asks for them"),
    "curves.newton_bezier": Bound(256, "the same curve in the form that lengths and boxes take"),
    "curves.extremes": Bound(1024, "planning asks for the box of a curve several times"),
    "curves.spline": Bound(256, "planning asks for the pieces of a spline several times"),
    "curves.division": Bound(64, "matrices of one degree and number of parts serve all curves"),
    "pages.templates": Bound(2, "a batch makes a page for each program"),
    "geometry.font": Bound(2, "the letters are read from their file, 1 ms"),
    "geometry.glyph": Bound(512, "a text has most of its characters several times"),
    "numbers.places": Bound(8, "all texts of so many decimals; up to 10,000 of them"),
    "planning.library": Bound(16, "the tools of a machine, sorted"),
    "planning.drills": Bound(4096, _OF_A_BUILDING),
    "planning.toolings": Bound(4096, _OF_A_BUILDING),
    "planning.sections": Bound(64, _OF_A_BUILDING),
    "planning.machines": Bound(16, "as many machines as a service runs"),
    "planning.fixed_faces": Bound(16, "each part asks which spindles stroke all through"),
    "planning.partner_faces": Bound(16, "each part asks which spindles of a machine work in pairs"),
    "planning.remarks": Bound(256, _OF_A_BUILDING),
    "planning.strokes": Bound(1024, _OF_A_BUILDING),
    "sections.walls": Bound(256, _OF_A_BUILDING),
    "simotion.runtime": Bound(16, "the text is the same for every job of a machine"),
    "simotion.trial": Bound(16, "the text is run once with simulated axes, 50 ms"),
    "simotion.block": Bound(64, "the blocks of a runtime are compiled once, some milliseconds"),
    "codesys.blocks": Bound(4096, "the programs of a job have many of their blocks in common"),
    "controllers.blocks": Bound(16, "as many machines as a service runs"),
    "codesys.words": Bound(1024, "the blocks of a job have most of their words in common"),
    "controllers.dialects": Bound(16, "as many machines as a service runs"),
    "emitters.machines": Bound(16, "as many machines as a service runs"),
    "emitters.strokes": Bound(1024, _OF_A_BUILDING),
    "motion.names": Bound(16, "as many machines as a service runs"),
    "motion.sections": Bound(64, _OF_A_BUILDING),
    "motion.machines": Bound(16, "as many machines as a service runs"),
    "motion.strokes": Bound(256, _OF_A_BUILDING),
    "verify.machines": Bound(16, "as many machines as a service runs"),
    "verify.cells": Bound(16, "as many machines as a service runs"),
    "verify.stations": Bound(
        256, "the positions of the spindles on a section hold for all programs"
    ),
    "verify.grades": Bound(64, "the cutting data of a steel hold for all programs in it"),
    "verify.runs": Bound(1024, _OF_A_BUILDING),
    "verify.sizes": Bound(64, _OF_A_BUILDING),
    "verify.fits": Bound(1024, _OF_A_BUILDING),
    "verify.tips": Bound(1024, _OF_A_BUILDING),
}


def cached(name: str) -> Callable[[Callable[Asked, Value]], Callable[Asked, Value]]:
    """Keeps what a function gives, by its arguments; those used longest ago go first."""

    def keeping(function: Callable[Asked, Value]) -> Callable[Asked, Value]:
        return cast("Callable[Asked, Value]", lru_cache(CACHES[name].max_entries)(function))

    return keeping


class BoundedCache(dict[Key, Value], Generic[Key, Value]):
    """A table of what was worked out before; full, it begins again.

    `get` looks, `keep` notes. It needs no lock: a look, a note and a clearing are one step each.
    """

    def __init__(self, name: str) -> None:
        super().__init__()
        self._max_entries = CACHES[name].max_entries

    def keep(self, key: Key, value: Value) -> Value:
        """What stands under `key` from now on: `value`, unless another thread was first."""
        if len(self) >= self._max_entries:
            self.clear()
        return self.setdefault(key, value)


class PerObject(Generic[Key, Value]):
    """Calls `make` once for each object, and gives the result from then on.

    Objects are told apart by identity: a machine holds tables and has no hash.
    """

    def __init__(self, name: str, make: Callable[[Key], Value]) -> None:
        self._make, self._max_entries = make, CACHES[name].max_entries
        self._known: tuple[tuple[Key, Value], ...] = ()  #: replaced as a whole, never changed
        self._lock = Lock()

    def __call__(self, key: Key) -> Value:
        for known, value in self._known:
            if self._is_same(known, key):
                return value
        made = self._make(key)
        with self._lock:
            for known, value in self._known:
                if self._is_same(known, key):
                    return value
            self._known = ((key, made), *self._known[: self._max_entries - 1])
        return made

    def _is_same(self, known: Key, key: Key) -> bool:
        return known is key


class PerMembers(PerObject[tuple[Other, ...], Value]):
    """Calls `make` once for tuples of the same objects, and gives the result from then on."""

    def _is_same(self, known: tuple[Other, ...], key: tuple[Other, ...]) -> bool:
        return len(known) == len(key) and all(map(is_, known, key))


class PerObjectAndKey(Generic[Key, Other, Value]):
    """Calls `make` once for each object and each key beside it: a machine and a section.

    Objects are told apart as in `PerObject`; what is known of one is a `BoundedCache`.
    """

    def __init__(self, objects: str, keys: str, make: Callable[[Key, Other], Value]) -> None:
        self._known = PerObject[Key, BoundedCache[Other, Value]](
            objects, lambda _: BoundedCache(keys)
        )
        self._make = make

    def __call__(self, one: Key, key: Other) -> Value:
        known = self._known(one)
        value = known.get(key)
        return known.keep(key, self._make(one, key)) if value is None else value
