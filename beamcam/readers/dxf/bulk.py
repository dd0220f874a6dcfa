"""The plain entities of model space taken out of a file, and the rest of it for ezdxf.

Where plain entities follow one another in the section ENTITIES, a marker takes their place, so
that the rest is a sound file and everything keeps its order. What might connect a plain entity
with the rest by its name, or by where it stands, leaves the whole file to ezdxf.
"""

from collections.abc import Iterable

import numpy as np
from msgspec import Struct

from beamcam.readers.dxf.layers import Attributes, Tables, tables_by_rows
from beamcam.readers.dxf.plain import (
    BEYOND,
    NOT_SAID,
    UNSAID,
    Codes,
    Says,
    ValuePlaces,
    Values,
    attributes_from,
    plan_of,
)
from beamcam.readers.dxf.rows import HANDLE, SUBCLASS, Rows, is_sound, rows_of

#: The kind of entity that marks plain entities in the remainder of a file.
MARKER = "BEAMCAM_PLAIN_ENTITIES"

R12 = "AC1009"

#: Group codes of names: of entities, and of dimension styles.
_NAMES = (HANDLE, 105)


class Plain(Struct, frozen=True, gc=False):
    """A plain entity and its numbers, as the function of `curves` for its kind takes them."""

    kind: str
    handle: str | None
    says: Attributes
    values: Values


Run = list[Plain]  #: plain entities that follow one another


class Taken(Struct, frozen=True):
    """Plain entities of a file and the text of the rest, with a marker for each run."""

    runs: tuple[Run, ...]
    rest: str
    owners: frozenset[str]  #: the layouts that the entities say they stand in
    tables: Tables | None = None  #: where nothing else is drawn, and ezdxf has nothing to say


def take_plain(text: str, version: str, named: bool) -> Taken | None:
    """The plain entities of model space and the rest; None if the file is one for ezdxf.

    Lines of `text` end in "\\n". `named` tells whether entities have names of their own (handles).
    """
    rows = rows_of(text)
    entities = rows.sections.get("ENTITIES") if rows is not None else None
    if rows is None or entities is None or MARKER in text:
        return None
    blocks = rows.sections.get("BLOCKS", range(0))
    if named and not _all_named(rows, (*entities, *blocks)):
        return None
    taker = _Taker(rows, version <= R12)
    taker.take(entities)
    if taker.odd or not taker.runs or taker.has_names_of_others():
        return None
    owners = frozenset(taker.owners - {UNSAID})
    is_whole = sum(map(len, taker.runs)) == len(entities)
    tables = tables_by_rows(rows, version <= R12) if is_whole and is_sound(rows, version) else None
    if tables is not None and not owners <= {tables.model_space}:
        tables = None
    return Taken(tuple(taker.runs), taker.rest() if tables is None else "", owners, tables)


def _codes(sequence: bytes) -> Codes:
    return tuple(np.frombuffer(sequence, np.int32).tolist())


def _all_named(rows: Rows, entities: Iterable[int]) -> bool:
    """Whether every entity has a handle above its subclasses; ends of blocks need none."""
    seen: dict[bytes, bool] = {}
    for first, _, sequence in rows.sequences(entities):
        if sequence not in seen:
            codes = _codes(sequence)
            head = codes[: codes.index(SUBCLASS)] if SUBCLASS in codes else codes
            seen[sequence] = HANDLE in head
        if not seen[sequence] and rows.value(first) not in ("BLOCK", "ENDBLK"):
            return False
    return True


class _Taker:
    """The entities taken so far, and their places."""

    def __init__(self, rows: Rows, r12: bool) -> None:
        self.rows = rows
        self.r12 = r12
        self.runs: list[Run] = []
        self.odd = False  #: whether a plain entity is where none is allowed
        self.owners: set[str] = set()
        self._spans: list[tuple[int, int]] = []  #: first row of each run, and the row behind it
        self._attributes: dict[Says, Attributes] = {}

    def take(self, entities: Iterable[int]) -> None:
        """Take those of the entities that are plain."""
        lines = self.rows.lines
        plans: dict[tuple[str, bytes], ValuePlaces | None] = {}
        goes_on = False  # whether the entity before goes on in the one that follows
        for first, last, sequence in self.rows.sequences(entities):
            row = lines[2 * first + 1 : 2 * last : 2]
            key = (row[0], sequence)
            try:
                plan = plans[key]
            except KeyError:
                plan = plans[key] = plan_of(row[0], _codes(sequence), self.r12)
            plain = None if plan is None else self._read(plan, row)
            if plain is None:
                goes_on = _goes_on(row, sequence)
                continue
            self.odd |= goes_on
            begun, behind = self._spans[-1] if self._spans else (0, 0)
            if behind == first:
                self._spans[-1] = begun, last
            else:
                self._spans.append((first, last))
                self.runs.append([])
            self.runs[-1].append(plain)

    def _read(self, plan: ValuePlaces, row: list[str]) -> Plain | None:
        row += BEYOND
        said = plan.attributes(row)
        try:
            attributes = self._attributes.get(said)
            if attributes is None:
                attributes = self._attributes[said] = attributes_from(*said)
            values = plan.read(row)
        except (ValueError, ArithmeticError):
            return None
        self.owners.add(row[plan.owner])
        return Plain(
            row[0], None if plan.handle == NOT_SAID else row[plan.handle], attributes, values
        )

    def has_names_of_others(self) -> bool:
        """Whether anything in the rest of the file has the handle of a plain entity."""
        handles = {plain.handle for run in self.runs for plain in run}
        names = np.isin(self.rows.codes, _NAMES)
        for first, last in self._spans:
            names[first:last] = False
        return any(self.rows.value(row) in handles for row in np.flatnonzero(names).tolist())

    def rest(self) -> str:
        """The text of the rest, with a marker for each run."""
        lines = self.rows.lines
        pieces: list[str] = []
        kept = 0
        for first, last in self._spans:
            pieces += lines[2 * kept : 2 * first]
            pieces += ("0", MARKER)
            kept = last
        return "\n".join((*pieces, *lines[2 * kept :], ""))


def _goes_on(row: list[str], sequence: bytes) -> bool:
    """Whether the vertices or attributes of an entity follow, up to a SEQEND."""
    if row[0] == "INSERT":
        codes = _codes(sequence)
        return 66 in codes and row[codes.index(66)].strip() != "0"
    return row[0] in ("POLYLINE", "VERTEX", "ATTRIB")
