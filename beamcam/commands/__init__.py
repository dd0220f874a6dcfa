"""The commands: thin wrappers that print. One module each, its click command is `command`.

Here are the rules for outputs, and for reports of a command on its work.
"""

from beamcam.errors import error, note

# fmt: off

OUTPUT_FORMAT = error("write-format",
    "found {found!r} for the output's format; expected one of {expected}, or --to",
    "The suffix of the output says how it is written.")
ONE_PART = error("write-one-part",
    "found {found} parts to write to {output!r}; expected one, or a folder/ for a file a part",
    "A DSTV file, a JSON part and a drawing of faces hold one part each.")
NO_PART = error("write-no-part",
    "found no part to write; expected at least one",
    "The file has none, the selection has none of the file's, or all are refused.")
CANNOT_WRITE = error("write-file",
    "{found!r} cannot be written ({reason}); expected a place with room that may be written to",
    "The disk is full, or the folder is not there or may not be written to. An old file still "
    "stands.")
OVER_INPUT = error("write-over-input",
    "found the output {found!r}, which is the file {read!r} that this command reads; expected "
    "another name or folder",
    "What a program is made from (parts, configuration, machine file) is never written over, by "
    "whatever name, link or letters the output is called.")
SETTINGS = note("run-settings",
    "{found}",
    "A report says whose configuration and which machine files, with their checksums, its programs "
    "were made by.")
MACHINE_ELSEWHERE = note("machine-elsewhere",
    "found the machine {found}, a file that is neither shipped nor among the user's own; expected "
    "it to be yours",
    "Programs are made by what a machine file says. Its checksum is what `sha256sum` begins with; "
    "a file that is kept with the user's own settings (`beamcam machines new --user`) is not told.")
SECTION = error("recover-no-section",
    "found {found!r} for the section; expected a part's file, or a name of the catalogue such as "
    "IPE200, HEB200, UPN200, L100X10 or RHS100X60X5",
    "The section of a bar is taken from a part's file or from the catalogue of rolled sections.")
RENAMED = note("write-renamed",
    "found mark {found!r} for the name {of}, which a part with mark {other!r} has; written to "
    "{name}",
    "Two parts that differ have one mark, or marks that differ only in characters that file names "
    "cannot have.")
WRITTEN = note("write-folder",
    "found {of} different parts, {members} in all; written {found} files",
    "Equal members are one file with their number as its quantity.")
MORE_BARS = error("write-more-bars",
    "found {found} bars for standard output; expected one, give -o a file's name",
    "Each bar has a program of its own: NAME-1, NAME-2 and so on.")
UNKNOWN_CODE = error("code-unknown",
    "found the code {found!r}; expected {expected}",
    "Codes keep their names from version to version. `beamcam codes` lists them.")
MISSING_EXTRA = error("extra-missing",
    "found no module {found!r}; expected it, pip install 'beamcam[{extra}]' brings it",
    "Some outputs are written by libraries that not everybody needs.")
ACCOUNT = note("account",
    "{found}",
    "What was done and how long it took, under `--verbose` with `--json`.")

NO_SAMPLE = error("check-sample",
    "found no sample {found!r} for {of}; expected one file of that name {where}, or --samples",
    "A golden program is checked by posting its part again. The part was moved, renamed or taken "
    "away, or there are two of its name.")
GONE = error("check-gone",
    "found no program {found!r} any more; expected it, as in the record of the batch",
    "The part of it is no longer in its file, is refused, or has another name now. The old program "
    "still stands.")
NEW = error("check-new",
    "found a new program {found!r}; expected it in the folder, --update writes it",
    "The file has more parts than it had, or its programs have other names.")
UNKNOWN = error("check-unknown",
    "found {found} program(s) that no record names and no machine's folder holds ({names}); "
    "expected none, or --stray for those that have no part here",
    "The parts of a program are in the record of its batch, or follow from a folder with the name "
    "of a machine. What cannot be posted again is not checked.")
NOTHING = error("check-nothing",
    "found no program to compare; expected what `batch` wrote, or a folder with the name of a "
    "machine",
    "The folder is empty, is another one, or none of its programs has a part here.")
