"""A hundred words of posts for tables as they are, each with what it means or the line to add.

From programs for QtPlasmaC, older LinuxCNC tables, Mach3, UCCNC, grbl, Hypertherm's controls (M07
cuts, M08 stops) and CODESYS. A word is read by itself, on a table whose file says what `codes` has.
"""

from pathlib import Path

import pytest

from beamcam.controllers import table_events
from beamcam.controllers.events import (
    Blending,
    Compensation,
    FeedShare,
    Lift,
    Material,
    Move,
    Other,
    Output,
    Pause,
    Switch,
    TableEvent,
    ToolOffset,
    Touch,
    Zero,
)
from beamcam.errors import MachineError
from beamcam.machine import Machine, load

#: Of LinuxCNC with Z in the program.
LIFTS = """base = "plate-linuxcnc"
[torch]
z = "program"
touch = "once"
top = 0
clearance = 20
touch_height = -2
[[axes]]
name = "x"
moves = "X"
speed = 100
acceleration = 1000
[[axes]]
name = "y"
moves = "Y"
speed = 100
acceleration = 1000
[[axes]]
name = "z"
moves = "Z"
speed = 50
acceleration = 500
"""
BASES = {
    "qtplasmac": 'base = "plate-qtplasmac"\n', "linuxcnc": 'base = "plate-linuxcnc"\n',
    "lifts": LIFTS, "mach3": 'base = "plate-mach3"\n', "grbl": 'base = "laser-grbl"\n',
    "codesys": 'base = "plate-codesys"\n',
}  # fmt: skip
#: Table, what its file says of the word, the word, and what it means; or the key that is missing.
WORDS = [
    # QtPlasmaC
    ("qtplasmac", "", "M3 $0 S1", "Switch M3 $0 S1"),
    ("qtplasmac", "", "M5 $0", "Switch M5 $0"),
    ("qtplasmac", "", "M3 $1 S1", "Switch M3 $1 S1"),
    ("qtplasmac", "", "M5 $1", "Switch M5 $1"),
    ("qtplasmac", "", "M3 $2 S1", "Switch M3 $2 S1"),
    ("qtplasmac", "", "M5 $-1", "Switch M5 $-1"),
    ("qtplasmac", "", "M52 P1", "Switch M52 P1"),
    ("qtplasmac", "", "M62 P2", "Output thc off with the move"),
    ("qtplasmac", "", "M63 P2", "Output thc on with the move"),
    ("qtplasmac", "", "M64 P2", "Output thc off"),
    ("qtplasmac", "", "M65 P2", "Output thc on"),
    ("qtplasmac", "", "M64 P1", "Switch M64 P1"),
    ("qtplasmac", '"M64P1" = "none"', "M64 P1", ""),
    ("qtplasmac", "", "M62 P3", "Output arc off with the move"),
    ("qtplasmac", "", "M67 E3 Q60", "FeedShare 0.6"),
    ("qtplasmac", "", "M67 E3 Q0", "FeedShare 1"),
    ("qtplasmac", "", "M68 E3 Q0", "FeedShare 1"),
    ("qtplasmac", "", "M68 E3 Q100", "FeedShare 1"),
    ("qtplasmac", "", "M67 E0 Q60", "codes.M67E0"),
    ("qtplasmac", "", "M190 P5", "Material number 5"),
    ("qtplasmac", "", "M190", "P or Q, as codes says"),
    ("qtplasmac", "", "M66 P3 L3 Q1", ""),
    ("qtplasmac", "", "(o=0, ph=3, pd=0.1, ch=1, fr=3000)",
     "Material pierce_height 3 pierce_s 0.1 cut_height 1 feed_mm_min 3000"),
    ("qtplasmac", "", "(o=2, nu=4, na=x, ph=3, pd=0.1, ch=1, fr=3000, th=1)",
     "Material pierce_height 3 pierce_s 0.1 cut_height 1 feed_mm_min 3000 thc 1"),
    ("qtplasmac", "", "(o=0, ph=3)", "a material without pd, ch, fr"),
    ("qtplasmac", "", "F#<_hal[plasmac.cut-feed-rate]>", "M190 with the number of a row"),
    ("qtplasmac", "", "#<holes>=0", ""),
    ("qtplasmac", "", "#<holes>=1", 'codes."#<holes>"'),
    ("qtplasmac", "", "#<pierce-only>=1", 'codes."#<pierce-only>"'),
    ("qtplasmac", "", "#<keep-z-motion>=1", 'codes."#<keep-z-motion>"'),
    ("qtplasmac", "", "#<h_diameter>=30", 'codes."#<h_diameter>"'),
    ("qtplasmac", '"#<oclength>" = "none"', "#<oclength>=4", ""),
    ("qtplasmac", "", "T1 M6", "Switch M6 T1"),
    ("qtplasmac", "", "G43 H0", "ToolOffset 0"),
    ("qtplasmac", "", "G43 H2", "ToolOffset 2"),
    ("qtplasmac", "", "G49", "ToolOffset 0"),
    ("qtplasmac", "", "G64 P0.1", "Blending 0.1"),
    ("qtplasmac", "", "G97", "codes.G97"),
    ("qtplasmac", '"G97" = "none"', "G97", ""),
    ("qtplasmac", "", "G0 Z10", "codes.Z"),
    # LinuxCNC of other tables
    ("linuxcnc", "", "M3 S1", "Switch M3 S1"),
    ("linuxcnc", "", "M4 S1", "Switch M4 S1"),
    ("linuxcnc", "", "M5", "Switch M5"),
    ("linuxcnc", "", "M62 P0", "Switch M62 P0"),
    ("linuxcnc", "", "M101", "codes.M101"),
    ("linuxcnc", '"M101" = "torch on"', "M101", "Switch M101 torch on"),
    ("linuxcnc", '"M102" = "torch off"', "M102", "Switch M102 torch off"),
    ("linuxcnc", '"M64P4" = "output on"', "M64 P4", "Output output 4 on"),
    ("linuxcnc", '"M65P4" = "output off"', "M65 P4", "Output output 4 off"),
    ("linuxcnc", '"M180" = "none"', "M180 P1 Q2", ""),
    ("linuxcnc", '"M181" = "feed share"', "M181 P50", "FeedShare 0.5"),
    ("linuxcnc", "", "o<touch> call", 'codes."o<touch>"'),
    ("linuxcnc", '"o<fan>" = "output on"', "o<fan> call [1]", "Output output on"),
    ("linuxcnc", "", "G41.1 D1.5", "Compensation left 0.75"),
    ("linuxcnc", "", "G4 P0.5", "Pause 0.5"),
    ("linuxcnc", "", "M48", "Switch M48"),
    ("linuxcnc", "", "M50 P0", "Switch M50 P0"),
    ("linuxcnc", "", "G92 X0 Y0", "expected none, it shifts"),
    ("linuxcnc", "", "G10 L2 P1 X0", "expected none, it shifts"),
    ("linuxcnc", "", "G28", "expected none, it shifts"),
    ("linuxcnc", "", "G38.2 Z-50 F300", "codes.G38.2"),
    ("lifts", "", "G38.2 Z-50 F300", "Touch -2 at 300"),
    ("lifts", "", "F250 G38.3 Z-50", "Touch -2 at 250"),
    ("lifts", "", "G92 Z-2", "Zero shifted"),
    ("lifts", "", "G92.1", "Zero"),
    ("lifts", "", "G10 L20 P0 Z0", "Zero"),
    ("lifts", "", "G10 L20 P1 Z0", "Zero"),
    ("lifts", "", "G10 L2 P1 Z0", "expected none, it shifts"),
    ("lifts", "", "G53 G0 Z0", "Lift to inf"),
    ("lifts", "", "G53 G0 Z-3", "Lift to nan"),
    ("lifts", "", "G43 H1", "expected none, it shifts"),
    ("lifts", '"M150" = "touch off"', "M150", "Touch -2 at nan, Zero, Lift to 0"),
    ("lifts", '"M151" = "height"', "M151 P3.8", "Lift to 3.8"),
    ("lifts", '"o<down>" = "touch off"', "o<down> call", "Touch -2 at nan, Zero, Lift to 0"),
    # Mach3 and UCCNC
    ("mach3", "", "M3", "Switch M3"),
    ("mach3", "", "M5", "Switch M5"),
    ("mach3", "", "G31 Z-100 F500", "Touch -3 at 500"),
    ("mach3", "", "G92 Z0.0", "Zero shifted"),
    ("mach3", "", "G92.1", "Zero"),
    ("mach3", "", "G04 P1.2", "Pause 1.2"),
    ("mach3", "", "M120", "Output thc on"),
    ("mach3", "", "M205", "codes.M205"),
    ("mach3", '"M205" = "thc on"', "M205", "Output thc on"),
    ("mach3", '"M206" = "thc off"', "M206", "Output thc off"),
    ("mach3", '"M20" = "thc off"', "M20", "Output thc off"),
    ("mach3", "", "M10 P1", "Switch M10 P1"),
    ("mach3", '"M10P1" = "torch on"', "M10 P1", "Switch M10 P1 torch on"),
    ("mach3", '"M11P1" = "torch off"', "M11 P1", "Switch M11 P1 torch off"),
    ("mach3", '"M11P3" = "output off"', "M11 P3", "Output output 3 off"),
    ("mach3", "", "M07", "Switch M7"),
    ("mach3", '"M07" = "torch on"', "M07", "Switch M7 torch on"),
    ("mach3", "", "G28.1 Z5", "expected none, it shifts"),
    ("mach3", "", "M47", "codes.M47"),
    ("mach3", "", "G68 R90", "expected none, it shifts"),
    ("mach3", "", "M98 P100", "codes.M98"),
    # grbl
    ("grbl", "", "M8", "Switch M8"),
    ("grbl", "", "M7", "Switch M7"),
    ("grbl", "", "M4 S500", "Switch M4 S500"),
    ("grbl", "", "M62 P1", "codes.M62P1"),
    ("grbl", "", "M106 S255", "codes.M106"),
    # CODESYS, and controls where M07 cuts and M08 stops
    ("codesys", "", "M03", "Switch M3"),
    ("codesys", "", "M21", "Switch M21"),
    ("codesys", '"M21" = "thc on"', "M21", "Output thc on"),
    ("codesys", '"M22" = "thc off"', "M22", "Output thc off"),
    ("codesys", '"M07" = "torch on"', "M07", "Switch M7 torch on"),
    ("codesys", '"M08" = "torch off"', "M08", "Switch M8 torch off"),
    ("codesys", '"M50" = "none"', "M50", ""),
    ("codesys", '"M64" = "preheat on"', "M64", "Output preheat on"),
    ("codesys", '"M65" = "preheat off"', "M65", "Output preheat off"),
    ("codesys", "", "G04 T0.5", "Pause 0.5"),
    ("codesys", "", "M98", "M98, a subprogram"),
]  # fmt: skip


def shown(event: TableEvent | Other) -> str:
    """An event in a few words."""
    match event:
        case Switch():
            return f"Switch {event} {event.does}".strip()
        case Output(_, name, on, with_move):
            return f"Output {name} {'on' if on else 'off'}{' with the move' if with_move else ''}"
        case FeedShare():
            return f"FeedShare {event.share:g}"
        case Material():
            return " ".join(["Material", *(f"{k} {v:g}" for k, v in event.values.items())])
        case ToolOffset():
            return f"ToolOffset {event.number}"
        case Touch():
            return f"Touch {event.height:g} at {event.feed_mm_min:g}"
        case Zero():
            return "Zero shifted" if event.shifted else "Zero"
        case Lift():
            return f"Lift to {event.end:g}"
        case Pause():
            return f"Pause {event.seconds:g}"
        case Blending():
            return f"Blending {event.distance:g}"
        case Compensation():
            return f"Compensation {event.side} {event.radius:g}"
        case Move():
            return "Move"
    return type(event).__name__


def table(base: str, codes: str, folder: Path) -> Machine:
    path = folder / "mine.toml"
    said = f"[codes]\n{codes}\n" if codes else ""
    path.write_text(BASES[base] + said)
    return load(str(path))


def test_there_are_a_hundred() -> None:
    assert len(WORDS) >= 100
    assert len({(base, codes, word) for base, codes, word, _ in WORDS}) == len(WORDS)


@pytest.mark.parametrize(("base", "codes", "word", "means"), WORDS)
def test_a_word_has_its_meaning_or_the_line_to_add(
    base: str, codes: str, word: str, means: str, tmp_path: Path
) -> None:
    events, said = table_events(f"{word}\nM30\n", table(base, codes, tmp_path))
    wrong = [d.message for d in said if d.code == "verify-sheet-word"]
    found = ", ".join(shown(event) for event in events[:-1])
    if wrong:
        assert len(wrong) == 1, wrong
        assert means, (found, wrong)
        assert means in wrong[0]
    else:
        assert found == means


@pytest.mark.parametrize(
    ("base", "word"),
    [(base, word) for base, _, word, means in WORDS if means.startswith("codes.M")],
)
def test_the_line_to_add_makes_it_known(base: str, word: str, tmp_path: Path) -> None:
    said = table_events(f"{word}\nM30\n", table(base, "", tmp_path))[1]
    (message,) = (d.message for d in said if d.code == "verify-sheet-word")
    key = message.partition("codes.")[2].split()[0]
    if base == "grbl":
        with pytest.raises(MachineError, match="grbl has no others"):
            table(base, f'{key} = "none"', tmp_path)
        return
    machine = table(base, f'{key} = "none"', tmp_path)
    assert not [
        d for d in table_events(f"{word}\nM30\n", machine)[1] if d.code == "verify-sheet-word"
    ]
