"""The rest of a part for the next machine, held against what a program leaves of it."""

from collections import Counter
from collections.abc import Collection, Iterator

from msgspec.structs import replace

from beamcam.errors import Diagnostic, Source, error
from beamcam.model.description import description
from beamcam.model.part import Part

REST = error("verify-rest",
    "found {found} in the rest of the part; expected {expected}",
    "What a program leaves out has to be what the next machine gets, and nothing else, or it is "
    "made twice or never. It is a fault of beamcam; send in the part.")  # fmt: skip
NOWHERE = Source("")


def rest_faults(part: Part, rest: Part, missing: Collection[int]) -> Iterator[Diagnostic]:
    """All differences of a rest, as it was read again, from what a program leaves of a part.

    `missing` are the features that the program does not make. Of both parts the figures have to be
    rounded as the format of the rest does.
    """
    source = rest.source
    for name in ("mark", "profile", "length", "quantity", "grade"):
        found, expected = getattr(rest, name), getattr(part, name)
        if found != expected:
            yield REST.at(source, found=f"{name} {found}", expected=str(expected))
    if rest.made is None:
        yield REST.at(source, found="a whole part", expected="one whose ends are there")
        return
    to_make = [f for k, f in enumerate(part.features) if k in missing]
    there = [*(part.made or ()), *(f for k, f in enumerate(part.features) if k not in missing)]
    for made, planned, how in (
        (rest.features, to_make, "to be made"), (rest.made, there, "as made")
    ):  # fmt: skip
        # Wherever they stand in their files.
        have, want = (
            Counter(replace(feature, source=NOWHERE) for feature in features)
            for features in (made, planned)
        )
        for feature in have - want:
            yield REST.at(source, found=f"{description(feature)} {how}", expected="none")
        for feature in want - have:
            yield REST.at(source, found=f"nothing {how} for it", expected=description(feature))
