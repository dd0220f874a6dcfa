"""Texts of a plan and of its read-back, which may stand in for each other.

A program does not say which of several texts that are alike is which, so that plan and read-back
may each share out their places by its own lights.
"""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence

from msgspec import Struct

from beamcam.checks.rules import TEXT_TOLD
from beamcam.errors import Diagnostic, Source
from beamcam.model.part import Part

TOLD_STEP = 0.1  #: mm that places and heights in messages are rounded to

Place = tuple[float, ...]  #: x, y and height


class _LetteredAt(Struct, frozen=True):
    """The place and height that a message about a text gives it."""

    source: Source
    place: Place
    drawn_at: Place
    letters: str

    def __str__(self) -> str:
        x, y, height = self.place
        return f"at x {x:g}, y {y:g}, {height:g} mm high"

    def is_at(self, places: Iterable[Place]) -> bool:
        """Whether it is at one of some places, each rounded to `TOLD_STEP`."""
        return any(
            max(abs(a - b) for a, b in zip(self.place, place, strict=True)) <= 1.01 * TOLD_STEP
            for place in places
        )


def stand_ins(parts: Sequence[Part]) -> dict[Source, Source]:
    """For the source of each text that of the first which is alike.

    They have the same letters and face and stand at the same angle; on bars they are texts of one
    part, while on a sheet one part's may stand for another's.
    """
    looks: dict[Source, set[tuple[object, ...]]] = {}
    for part in parts:
        for one in part.texts:
            of = ("", "") if part.profile.code == "B" else (one.source.file, part.mark)
            look = *of, one.text, one.face, one.angle % 360.0
            looks.setdefault(one.source, set()).add(look)
    first: dict[object, Source] = {}
    return {source: first.setdefault(frozenset(each), source) for source, each in looks.items()}


def other_places(
    remarks: Iterable[Diagnostic], diagnostics: Iterable[Diagnostic],
    alike: Mapping[Source, Source], manual_work: Collection[Source],
) -> Iterator[Diagnostic]:  # fmt: skip
    """Texts that are found moved elsewhere than the plan tells, or of which it tells nothing.

    `manual_work` are the sources of marks that the plan left for manual work; which of several
    equal texts these are, a program does not tell either.
    """
    groups: dict[tuple[Source, str], tuple[list[_LetteredAt], list[_LetteredAt]]] = {}
    for which, messages in enumerate((remarks, diagnostics)):
        for diagnostic in messages:
            at, drawn_at = (
                tuple(float(diagnostic[f"{of}{name}"]) for name in ("x", "y", "height"))
                for of in ("", "wanted_")
            )
            one = _LetteredAt(diagnostic.source, at, drawn_at, str(diagnostic["text"]))
            group = alike.get(one.source, one.source), one.letters
            groups.setdefault(group, ([], []))[which].append(one)
    left = {alike.get(source, source) for source in manual_work}
    for (source, _), (planned, moved) in groups.items():
        theirs, ours = {one.drawn_at for one in planned}, {one.drawn_at for one in moved}
        elsewhere = [one for one in moved if not one.is_at(each.place for each in planned)]
        untold = [one for one in planned if not one.is_at(each.place for each in moved)]
        if not elsewhere and not untold and theirs != ours and source not in left:
            elsewhere = [one for one in moved if one.drawn_at not in theirs]
            untold = [one for one in planned if one.drawn_at not in ours]
        else:  # one moved to where the part has another of them: that other is in place
            elsewhere = [one for one in elsewhere if not one.is_at(ours - theirs - {one.drawn_at})]
            untold = [one for one in untold if not one.is_at(theirs - ours - {one.drawn_at})]
        for one in elsewhere:
            yield TEXT_TOLD.at(one.source, found=one, expected="elsewhere")
        for one in untold:
            yield TEXT_TOLD.at(one.source, found="elsewhere", expected=one)
