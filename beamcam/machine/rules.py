"""What can be wrong with a machine file."""

from beamcam.errors import Rule, Severity

UNKNOWN_MACHINE = Rule(
    "machine-unknown",
    Severity.ERROR,
    "found no machine {found!r}; expected {expected}",
    "A machine is one of those shipped (`beamcam machines list`) or the path of a TOML file.",
)
NOT_TOML = Rule(
    "machine-toml",
    Severity.ERROR,
    "found no TOML ({found}); expected key = value, or a [table]",
    "The file breaks the rules of TOML at that line.",
)
UNKNOWN_KEY = Rule(
    "machine-key",
    Severity.ERROR,
    "found unknown key {found!r}; expected {expected}",
    "A misspelt limit would leave the machine without that limit, so no key is ignored.",
)
MISSING_KEY = Rule(
    "machine-missing",
    Severity.ERROR,
    "found no key {expected!r}; expected it, it is required",
    "The key has no default because a wrong guess could hurt the machine.",
)
WRONG_VALUE = Rule(
    "machine-value",
    Severity.ERROR,
    "found {found} for {key!r}; expected {expected}",
    "The value is of the wrong kind, out of its range, or names something that does not exist.",
)
BASE_LOOP = Rule(
    "machine-base",
    Severity.ERROR,
    "found the machine {found!r} among its own bases; expected another one",
    "A machine file may build on another by `base`, but not on itself.",
)

RULES = (UNKNOWN_MACHINE, NOT_TOML, UNKNOWN_KEY, MISSING_KEY, WRONG_VALUE, BASE_LOOP)
