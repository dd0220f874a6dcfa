"""Batches: many files in, a folder of programs and an account out.

    find -> run -> workers (here, processes, a cluster) -> rows

`find.find_inputs` says which files are meant, `run.run` posts them and gives a row for each.
"""

from beamcam.errors import error, note, warning

# fmt: off

NOTHING = error("batch-nothing",
    "found no input for {found!r}; expected a file, a folder that holds one, or a pattern",
    "A pattern that matches nothing is often a wrong folder.")
LOOP = warning("batch-loop",
    "found a link back to {found}, which is not followed",
    "Following it would never end, or would post files outside the inputs.")
FOLDER = error("batch-folder",
    "found a folder that cannot be listed ({found}); expected one that can be read",
    "Its files would be left out silently.")
NO_PART = error("batch-no-part",
    "found no part in the file; expected at least one",
    "Exporting an empty selection writes such a file.")
SAME_NAME = error("batch-same-name",
    "found {found!r} for the output's name, which {other} has; expected a name of its own, by "
    "--tree or --name",
    "One program would be written over by the other.")
OTHER_CONTENT = error("list-mark-twice",
    "found another part with the mark {found!r}{where} in {other}; expected one content for one "
    "mark of an order, or --mark-from drawing, file or position",
    "Two parts that differ under one mark of an order and phase get mixed up in the shop. Give one "
    "of them another mark, leave its file out, or take the marks from where they differ.")
STALE_SHARE = warning("batch-stale-share",
    "{found!r} still stands from an earlier run over stock; expected it to be of this one",
    "The pieces lie on other bars or sheets now; the older program would make them twice.")
OVER_INPUT = error("batch-over-input",
    "found the output {found!r}, which is the file {read!r} that this run reads; expected another "
    "name or folder",
    "The program would be written over a part, the configuration or a machine file.")
LINK = error("batch-link",
    "found {found!r}, which leads out of the folder of the outputs by a link, to {to!r}; expected "
    "a place in the folder, remove the link",
    "Writing through such a link would overwrite a file outside the folder.")
NOT_OURS = error("batch-not-ours",
    "found {found!r} there already, {why}; expected a program as a batch made it, `batch --force` "
    "writes over it",
    "What somebody else put there, edited, or made read-only is not lost without being asked for.")
NO_END = warning("batch-no-end",
    "found no end of the file for {found} s (EN, END-ISO-10303-21, EOF, </svg>, the closing "
    "bracket); expected its writer to be done, --end-wait waits longer",
    "A writer may pause in mid file. A file that stays without its end is read as it stands.")
WRITE = error("batch-write",
    "{found!r} cannot be written ({reason}); expected a folder with room that may be written to",
    "The disk is full, or the folder may not be written to. The old file, if any, still stands; of "
    "several programs for one part none is new.")
KEPT = note("verify-kept",
    "the refused program is kept in {found}; look at the lines that the messages name",
    "A program that does not make the part is never written where a machine would take it. Under "
    "this name it can be inspected, or sent in with a report.")
OWN_REST = note("batch-own-rest",
    "found what this batch left of a part for the next machine; it is no input of it",
    "The outputs lie among the inputs. The part itself is an input, and all of it is made.")
RECORD = warning("batch-record",
    "the record of the batch cannot be kept ({found}); the next run does these files again",
    "Without its record a batch does not know which inputs are unchanged.")
STALE = warning("batch-stale",
    "{found!r} still stands from an earlier run; expected it to be of this input",
    "The input was posted before, and is refused now or made by other machines; none should run "
    "the older program.")
DIED = error("batch-worker",
    "found the worker process dead at this file, twice; expected it to finish (out of memory, or a "
    "fault in a library)",
    "The process was ended by the system, most often for its memory. Other files are not touched.")
INTERNAL = error("batch-internal",
    "found a fault of beamcam: {found}; expected none, please report it with the file",
    "The part was not posted. Other files are not touched.")
SCHEDULER = error("batch-scheduler",
    "found no cluster that works at {address} ({found}); expected a Dask scheduler with workers "
    "that have beamcam {version}",
    "Install the extra `dask` here, and the same beamcam on every worker.")
