"""Rules for machine files."""

from beamcam.errors import error, warning

# fmt: off

UNKNOWN_MACHINE = error("machine-unknown",
    "found no machine {found!r}; expected {expected}",
    "A machine is one of those shipped (`beamcam machines list`) or the path of a TOML file.")
NAME_TWICE = error("machine-name-twice",
    "found a machine of your own with the name {found!r} of one that is shipped; expected another "
    "name, of the file and of its key `name`",
    "Which of the two a job means would be a guess, and a program's head would name a machine that "
    "did not make it.")
NOT_TOML = error("machine-toml",
    "found no TOML ({found}); expected key = value, or a [table]",
    "The file breaks the rules of TOML at that line.")
UNKNOWN_KEY = error("machine-key",
    "found unknown key {found!r}; expected {expected}",
    "A misspelt limit would leave the machine without that limit, so no key is ignored.")
MISSING_KEY = error("machine-missing",
    "found no key {expected!r}; expected it, it is required",
    "The key has no default because a wrong guess could hurt the machine.")
WRONG_VALUE = error("machine-value",
    "found {found} for {key!r}; expected {expected}",
    "The value is of the wrong kind, out of its range, or names something that does not exist.")
WORD = error("machine-word",
    "in {key!r}, {said}",
    "The words of a machine file are tried on its controller before planning: a word that the "
    "read-back would refuse in every program is a fault of the file.")
BASE_LOOP = error("machine-base",
    "found the machine {found!r} among its own bases; expected another one",
    "A machine file may build on another by `base`, but not on itself.")

CHART = error("machine-chart",
    "found {found}; expected {expected}",
    "A row of a chart that is left out, or read as another thickness, would cut by wrong figures.")
FORMER_KEY = warning("machine-former-key",
    "found the key {found!r} of an older version; expected {expected!r}",
    "The key is read for one more minor version. Rename it in the file; nothing else changes.")
KEY_TWICE = error("machine-key-twice",
    "found {found!r}, the older name of {expected!r}, beside it; expected one of them",
    "Two names of one key could have two values. Remove the older one.")

RULES = (
    UNKNOWN_MACHINE, NAME_TWICE, NOT_TOML, UNKNOWN_KEY, MISSING_KEY, WRONG_VALUE, WORD,
    BASE_LOOP, CHART, FORMER_KEY, KEY_TWICE,
)  # fmt: skip
