"""What a program leaves of its part, as the file that the next machine gets.

    part  ->  program 1              what it leaves out, or leaves for manual work
          ->  rest of the part  ->  program 2

The rest is read again before it is written: program and rest together are the part.
"""

from collections.abc import Sequence

from msgspec.structs import replace

from beamcam import readers
from beamcam.errors import ReadError, VerifyError, errors_in, note
from beamcam.model.part import Feature, Part
from beamcam.model.plan import NOT_MADE
from beamcam.pipeline import Posted, read_back
from beamcam.planning.begun import begun_part
from beamcam.verify.begun import rest_faults
from beamcam.verify.left_out import BY_HAND, LEFT_OUT
from beamcam.writers import Target

REST = note("plan-rest",
    "the rest of the part, {found} feature(s), is written; the piece that comes has finished ends",
    "The next machine gets what this program does not make. In its file what is there stands in "
    "comments, or under `made` in JSON.")  # fmt: skip
NO_REST = note("plan-no-rest",
    "found no rest of the part: the program makes all of it",
    "Nothing is left for another machine, so no file of it is written.")  # fmt: skip
RULES = (REST, NO_REST)


def rest_of_part(posted: Posted, target: Target) -> tuple[Part, str] | None:
    """What a program leaves of its part, as it is read again, and its text; None if nothing.

    The program has to be that of one part. Raises VerifyError where program and rest together are
    not that part, BeamcamError for what the format cannot hold.
    """
    job = posted.job
    (part,) = job.request.parts
    if not any(outcome.how in NOT_MADE for outcome in posted.plan.outcomes):
        return None
    missing = {part.features[o.feature[1]].source for o in posted.plan.outcomes
               if o.feature[0] == 0 and o.how in NOT_MADE}  # fmt: skip
    if job.request.verified:  # the plan's word is not needed
        said = read_back(posted.text, job.request, job.bar)
        missing = {one.source for one in said if one.code in (LEFT_OUT.code, BY_HAND.code)}
        missing &= {f.source for f in part.features}
    text = target.write(begun_part(part, posted.plan, job.machine))
    rest = _read(text, target)
    faults = tuple(rest_faults(_as_written(part, target), rest, missing))
    if faults:
        raise VerifyError(faults)
    return rest, text


def _read(text: str, target: Target) -> Part:
    """The part of a text that was written here. Raises ReadError."""
    reading = readers.read(text.encode(), f"rest{target.suffixes[0]}")
    if errors_in(reading.diagnostics) or len(reading.parts) != 1:
        raise ReadError(reading.diagnostics)
    return reading.parts[0]


def _as_written(part: Part, target: Target) -> Part:
    """A part with its figures as a format has them, its features where they stood."""
    again = _read(target.write(part), target)

    def placed(features: Sequence[Feature], of: Sequence[Feature]) -> tuple[Feature, ...]:
        return tuple(replace(f, source=o.source) for f, o in zip(features, of, strict=True))

    made = None if part.made is None else placed(again.made or (), part.made)
    return replace(again, features=placed(again.features, part.features), made=made)
