"""A golden program and what became of it: where its part lies, what it makes otherwise."""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Literal

from msgspec import Struct

from beamcam import readers
from beamcam.commands import NEW, NO_SAMPLE
from beamcam.commands.common import Console, say_json, say_lines
from beamcam.comparison.pairing import Difference
from beamcam.comparison.statements import ProgramText, diff_texts
from beamcam.errors import ReadError, Severity, Source, errors_in
from beamcam.machine import Machine
from beamcam.planning.manual_list import LIST_SUFFIX, ManualRow, as_csv
from beamcam.reports.run import Message, as_message, message_line

Result = Literal[
    "same", "bytes", "differs", "refused", "missing", "unknown", "only in A", "only in B"
]
MOST_NAMED = 3  #: programs of a group that are named
TEXTS = {"bytes": "another text that means the same", "differs": "makes something else"}


class Checked(Struct, frozen=True):
    """The outcome of one golden program."""

    path: str
    #: "bytes" is another text that means the same, "missing" one without its sample; "unknown" are
    #: all programs of a folder whose sources are not known; of two folders, in which one it is
    result: Result
    differences: tuple[Difference, ...] = ()
    messages: tuple[Message, ...] = ()
    new: bytes | None = None  #: the program as it is made now, if it or its list is another
    manual_work: Sequence[ManualRow] = ()  #: the list beside it, as it is made now


def compared(
    path: str, old: bytes, new: bytes, machine: Machine, manual_work: Sequence[ManualRow]
) -> Checked:
    """A golden program with its list of manual work, and those that are made now."""
    beside = Path(path + LIST_SUFFIX)
    was = beside.read_bytes() if beside.is_file() else b""
    listed: tuple[Difference, ...] = ()
    if was != (as_csv(manual_work).encode("utf-8") if manual_work else b""):
        text = f"found {len(was.splitlines()[1:])} mark(s) of manual work, now {len(manual_work)}"
        listed = (Difference("feature", "changed", f"{beside.name}: {text}"),)
    if old == new and not listed:
        return Checked(path, "same")
    if old == new:
        return Checked(path, "differs", listed, (), new, manual_work)
    before, now = (data.decode("utf-8", "replace") for data in (old, new))
    differences, diagnostics = diff_texts(
        ProgramText(path, before, machine), ProgramText(f"{path}, as it is made now", now, machine)
    )
    diagnostics = errors_in(diagnostics)
    result: Result = "differs" if differences or diagnostics or listed else "bytes"
    differences = (*differences, *listed)
    return Checked(path, result, differences, tuple(map(as_message, diagnostics)), new, manual_work)


def sample_of(samples: Path, stem: str, program: str, suffix: str = "") -> Path:
    """The file of a sample below a folder, whatever its format. Raises ReadError unless it is one.

    `suffix` is that of the sample where it is known.
    """
    known = {suffix} if suffix else {s for f in readers.FORMATS for s in f.suffixes}
    alike = (p for p in samples.rglob("*") if p.suffix.lower() in known and p.stem == stem)
    files = sorted(path for path in alike if path.is_file())
    if len(files) > 1:
        files = [p for p in files if "bad" not in p.relative_to(samples).parts] or files
    if len(files) == 1:
        return files[0]
    where = f"in {samples} (found {', '.join(map(str, files))})" if files else f"in {samples}"
    diagnostic = NO_SAMPLE.at(
        Source(program), found=stem + suffix, of=Path(program).name, where=where
    )
    raise ReadError(diagnostic)


def lines_of(results: Sequence[Checked]) -> Iterator[str]:
    """Messages on the programs that differ, one line for a difference common to several.

    A change of a machine is one line, however many programs it changes.
    """
    alike: dict[tuple[str, ...], list[Checked]] = defaultdict(list)
    for one in results:
        if one.result in TEXTS and not one.messages:
            alike[(one.result, *(d.of_all or d.text for d in one.differences))].append(one)
    for (result, *texts), group in alike.items():
        if len(group) > 1:
            text = ", ".join(texts) or TEXTS[result]
            yield f"{len(group)} programs: {text} ({named([c.path for c in group])})"
        else:
            (one,) = group
            if len(one.differences) == 1:
                yield f"{one.path}: {one.differences[0].text}"
                continue
            yield f"{one.path}: {TEXTS[result]}"
            yield from (f"  {difference.text}" for difference in one.differences)
    for one in results:
        if one.messages and one.result == "differs":
            is_new = any(text["code"] == NEW.code for text in one.messages)
            yield f"{one.path}: {'not in the folder' if is_new else TEXTS[one.result]}"
            yield from (f"  {difference.text}" for difference in one.differences)
        elif one.result in ("only in A", "only in B"):
            yield f"{one.path}: {one.result}"


def named(paths: Sequence[str]) -> str:
    """The first names of a group, and how many more there are."""
    shown = ", ".join(paths[:MOST_NAMED])
    more = len(paths) - MOST_NAMED
    return f"{shown} and {more} more" if more > 0 else shown


def say_results(
    results: Sequence[Checked], counts: str, console: Console, as_json: bool,
    silent: Result = "same",
) -> None:  # fmt: skip
    """Print the results, as JSON or as lines; those that are `silent` have none.

    `counts` is the last line, if there is any.
    """
    severities = {severity.value for severity in Severity if console.wants(severity)}
    messages = [[m for m in r.messages if m["severity"] in severities] for r in results]
    if as_json:
        say_json([
            {"file": r.path, "result": r.result,
             "differences": [d.as_data() for d in r.differences], "messages": of_one}
            for r, of_one in zip(results, messages, strict=True)
        ])  # fmt: skip
        return
    say_lines(lines_of([r for r in results if r.result != silent]))
    say_lines((message_line(m) for of_one in messages for m in of_one), err=True)
    if counts and not console.quiet:
        say_lines([counts])
