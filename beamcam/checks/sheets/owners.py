"""What answers for each word of a sheet's program, and for each event that is made of it.

`tests/test_sheet_words.py` puts every word into every state of programs: what none of the codes of
its row refuses leaves the head on its way, for the reason that stands there.
"""

from beamcam.checks import Language, Owner, Stock

#: The path with the tool on, compared with the contours.
_PATH = (
    "verify-sheet-missing", "verify-sheet-extra", "verify-sheet-twice", "verify-sheet-side",
    "verify-sheet-band", "verify-sheet-lead", "verify-sheet-pierce", "verify-sheet-open",
    "verify-sheet-restart", "verify-sheet-overcut", "verify-sheet-direction", "verify-sheet-tab*",
)  # fmt: skip
_MOVED = (
    *_PATH, "verify-sheet-rapid", "verify-sheet-height", "verify-sheet-idle", "verify-sheet-area",
    "verify-sheet-word",
    "verify-sheet-end", "verify-sheet-setting", "verify-sheet-tool", "verify-sheet-compensation",
    "verify-sheet-feed", "verify-sheet-ramp", "verify-sheet-arc",
)  # fmt: skip
_WORD = ("verify-sheet-word",)
_TOOL = ("verify-sheet-tool", "verify-sheet-word", "verify-sheet-end", "verify-sheet-height",
         "verify-sheet-thc", "verify-sheet-output")  # fmt: skip
_LIFTED = ("verify-sheet-height", "verify-sheet-thc", "verify-sheet-output", *_WORD,
           "verify-sheet-end")  # fmt: skip
_SWITCHED = ("verify-sheet-thc", "verify-sheet-output", "verify-sheet-end")
_AGAIN = "says again what holds already"
_ELSEWHERE = "names no place, or the head goes there with its tool off"
_WAITS = "waits with the tool off"
_OFF = "no tool is on"
_AIR = "coolant and air change no path"
_STOPS = "the operator goes on, with no tool on"
_OVERRIDE = "says whether the operator may change feeds"
_HEIGHT = "changes heights only, or takes back what no program may have set"
_OFFSETS = ("G54", "G55", "G56", "G57", "G58", "G59")

_OF_ALL = (
    Owner(("M2", "M30"), (), ("verify-sheet-end",)),
    Owner(("G40",), (), (*_PATH, "verify-sheet-tool", "verify-sheet-end"), "no compensation is on"),
    Owner(("G90",), (), ("verify-sheet-end",), _AGAIN),
    Owner(("G91",), (), _MOVED, "no move follows"),
)

_RS274 = (
    *_OF_ALL,
    Owner(("G0",), (), _MOVED, _ELSEWHERE),
    Owner(("G0",), ("X", "Y"), _MOVED, _ELSEWHERE),
    Owner(("G1",), (), _MOVED, "names no place"),
    Owner(("G1",), ("X", "Y"), _MOVED, "names the place where the head is"),
    Owner(("G2", "G3"), (), _MOVED, "names no place"),
    Owner(("G2", "G3"), ("X", "Y", "I", "J"), _MOVED),
    Owner(("F",), (), ("verify-sheet-feed", "verify-sheet-end"),
        "each stroke says its own, and a traverse has none"),
    Owner(("G4",), (), (*_WORD, "verify-sheet-end")),
    Owner(("G4",), ("P",), ("verify-sheet-tool", "verify-sheet-end"), _WAITS),
    Owner(("G17", "G21", "G94", "G91.1"), (), ("verify-sheet-end",), _AGAIN),
    Owner(("M3", "M4"), (), _TOOL),
    Owner(("M5",), (), (*_TOOL, *_PATH, "verify-sheet-idle"), _OFF),
    Owner(("M7", "M8", "M9"), (), _TOOL, _AIR),
    Owner(("M0", "M1"), (), _TOOL, _STOPS),
    Owner(("S",), (), _TOOL, "no tool is on, or it is the speed that holds already"),
    Owner(("T",), (), ("verify-sheet-end",), "the machine's words say which tool works"),
    Owner(("G49", "G53", "G92.1"), (), _LIFTED, _HEIGHT),
    Owner(_OFFSETS, (), (*_WORD, "verify-sheet-end"), "one offset holds for the whole program"),
    Owner(("G80",), (), _MOVED, "no cycle holds"),
)  # fmt: skip

_LINUXCNC = (
    *_RS274,
    Owner(("G43.1",), (), ("verify-sheet-end",), _HEIGHT),
    Owner(("G43.1",), ("Z",), ("verify-sheet-end",), _HEIGHT),
    Owner(("G41.1", "G42.1"), (), _MOVED),
    Owner(("G41.1", "G42.1"), ("D",), _MOVED),
    Owner(("G61", "G61.1", "G64"), (), ("verify-sheet-corner", "verify-sheet-end")),
    Owner(("G64",), ("P",), ("verify-sheet-corner", "verify-sheet-end"), _AGAIN),
    Owner(("G64",), ("Q",), (*_WORD, "verify-sheet-corner", "verify-sheet-end")),
    Owner(("G73", "G81", "G82", "G83"), (), _MOVED),
    Owner(("G73", "G81", "G82", "G83"), ("X", "Y", "R"), _MOVED),
    Owner(("G73", "G83"), ("Q",), _MOVED),
    Owner(("G82",), ("P",), _MOVED),
    Owner(("G98", "G99"), (), ("verify-sheet-end",), "no cycle holds"),
    Owner(("M3", "M4", "M5"), ("$",), (*_TOOL, *_PATH, "verify-sheet-idle"), _OFF),
    Owner(("M3", "M4"), ("S",), _TOOL),
    Owner(("M6",), (), _TOOL, _STOPS),
    Owner(("M6",), ("T",), _TOOL, _STOPS),
    Owner(("M60",), (), _TOOL, _STOPS),
    Owner(("M48", "M49", "M50", "M51", "M52", "M53"), (), _TOOL, _OVERRIDE),
    Owner(("M50", "M51", "M52", "M53"), ("P",), _TOOL, _OVERRIDE),
    Owner(("M51",), ("$",), _TOOL, _OVERRIDE),
    Owner(("G92.2",), (), ("verify-sheet-end",), _HEIGHT),
    Owner(("G43",), (), (*_WORD, "verify-sheet-output", "verify-sheet-end"), _HEIGHT),
    Owner(("G43",), ("H", "Z"), (*_WORD, "verify-sheet-output", "verify-sheet-end"), _HEIGHT),
    Owner(("G59.1", "G59.2", "G59.3"), (), (*_WORD, "verify-sheet-end"),
        "one offset holds for the whole program"),
    Owner(("M62", "M63", "M64", "M65"), (), _TOOL),
    Owner(("other",), ("{share}",), ("verify-sheet-feed", "verify-sheet-hole-feed")),
    Owner(("M62", "M63", "M64", "M65"), ("P",), _TOOL, "[codes] says what it does, and that says "
        "again what holds already"),
    Owner(("other",), (), _TOOL),
)  # fmt: skip

_MACH3 = (
    *_RS274,
    Owner(("G0", "G1"), ("Z",), (*_LIFTED, *_MOVED), "the torch is at that height already, or "
        "goes up and comes to the row's again"),
    Owner(("G31",), (), _LIFTED),
    Owner(("G31",), ("Z",), _LIFTED, "Z is called anew, or touches again, before it counts"),
    Owner(("G10", "G92"), (), _LIFTED),
    Owner(("G10",), ("L", "P"), _LIFTED, "Z is called anew, or touches again, before it counts"),
    Owner(("G10", "G92"), ("Z",), _LIFTED, "Z is called anew, or touches again, before it counts"),
    Owner(("G92.2",), (), _LIFTED, _HEIGHT),
    Owner(("G61", "G64"), (), ("verify-sheet-end",), "corners are passed as is set there"),
    Owner(("M3", "M4"), ("S",), _TOOL),
    Owner(("M6",), (), _TOOL, _STOPS),
    Owner(("M6",), ("T",), _TOOL, _STOPS),
    Owner(("M60",), (), _TOOL, _STOPS),
    Owner(("M10", "M11"), (), _TOOL),
    Owner(("M10", "M11"), ("P",), _TOOL),
    Owner(("M48", "M49"), (), _TOOL, _OVERRIDE),
    Owner(("other",), (), _TOOL),
)  # fmt: skip

#: Words of a table's own, by what its file says that they do.
_HELD = (
    Owner(("codes: thc on", "codes: thc off"), (), _SWITCHED, _AGAIN),
    Owner(("codes: output on", "codes: output off"), (), _SWITCHED, "an output may be on on the "
        "way, and is off at the end"),
)  # fmt: skip
_OF_CODES = (
    *_HELD,
    Owner(("codes: none",), (), (*_WORD, "verify-sheet-end"), "the machine's file says that it "
        "does nothing"),
    Owner(("codes: torch on", "codes: torch off", "codes: cutting oxygen on",
        "codes: cutting oxygen off"), (), (*_TOOL, *_PATH, "verify-sheet-idle"), _OFF),
    Owner(("codes: arc on", "codes: arc off"), (), ("verify-sheet-dark", "verify-sheet-output",
        "verify-sheet-end"), "no cut follows, or it says again what holds already"),
    Owner(("codes: preheat on", "codes: preheat off"), (), _SWITCHED, _AGAIN),
    Owner(("codes: feed share",), (), (*_WORD, "verify-sheet-feed", *_SWITCHED), _AGAIN),
    Owner(("codes: material",), (), (*_WORD, "verify-sheet-material", "verify-sheet-end"),
        "no contour is cut with it"),
)  # fmt: skip

_GRBL = (
    *_RS274,
    Owner(("G43.1",), (), ("verify-sheet-end",), _HEIGHT),
    Owner(("G43.1",), ("Z",), ("verify-sheet-end",), _HEIGHT),
    Owner(("G61",), (), ("verify-sheet-end",), "grbl knows no other mode"),
    Owner(("M3", "M4"), ("S",), _TOOL),
    Owner(("M4",), ("{power}", "{feed}"), (*_TOOL, "verify-sheet-feed", "verify-sheet-settings")),
)

_CODESYS = (
    *_OF_ALL,
    Owner(("G40", "G41", "G42"), ("D",), _MOVED, "no compensation is on"),
    Owner(("G0",), (), _MOVED, _ELSEWHERE),
    Owner(("G0",), ("X", "Y"), _MOVED, _ELSEWHERE),
    Owner(("G1",), (), _MOVED, "names no place"),
    Owner(("G1",), ("X", "Y"), _MOVED, "names the place where the head is"),
    Owner(("G1",), ("F", "E", "E-"), _MOVED),
    Owner(("G2", "G3", "G6", "G8", "G9"), (), _MOVED, "names no place"),
    Owner(("G2", "G3", "G6", "G8", "G9"), ("X", "Y", "I", "J", "F", "E", "E-"),
        _MOVED),
    Owner(("G2", "G3", "G8", "G9"), ("R",), _MOVED),
    Owner(("G8", "G9"), ("K",), _MOVED),
    Owner(("G4",), (), (*_WORD, "verify-sheet-end")),
    Owner(("G4",), ("T",), ("verify-sheet-tool", "verify-sheet-end"), _WAITS),
    Owner(("G41", "G42"), (), _MOVED),
    Owner(("G50", "G53"), (), ("verify-sheet-end",), "takes back what G51 to G55 said; a place "
        "that is another one then is refused itself"),
    Owner(("G51", "G52"), (), (*_WORD, "verify-sheet-end")),
    Owner(("G51", "G52"), ("D",), (*_WORD, "verify-sheet-corner", "verify-sheet-end"), _AGAIN),
    Owner(("G54", "G55"), (), (*_WORD, "verify-sheet-end")),
    Owner(("G54", "G55"), ("X", "Y"), _MOVED, "no place is said behind it"),
    Owner(("G56", "M98", "M99"), (), (*_WORD, "verify-sheet-end")),
    Owner(("M4",), (), _TOOL),
    Owner(("M7", "M8", "M9"), (), _TOOL, _AIR),
    Owner(("G75",), (), ("verify-sheet-end",), "waits until what was read is done"),
    Owner(("G98",), (), ("verify-sheet-arc", "verify-sheet-end", *_PATH), "no arc follows"),
    Owner(("G99",), (), ("verify-sheet-end",), _AGAIN),
    Owner(("M3",), (), _TOOL),
    Owner(("M5",), (), (*_TOOL, *_PATH, "verify-sheet-idle"), _OFF),
    Owner(("other",), (), _TOOL),
)  # fmt: skip

_EVENTS = (
    Owner(("Move.rapid",), (), ("verify-sheet-rapid", "verify-sheet-idle")),
    Owner(("Move.start", "Move.end", "Move.curve"), (), (*_PATH, "verify-sheet-area",
        "verify-sheet-radius", "verify-sheet-order", "verify-sheet-turn")),
    Owner(("Move.feed_mm_min",), (), ("verify-sheet-feed",)),
    Owner(("Move.own_feed",), (), (), "only strokes of drills have a feed of their own"),
    Owner(("Move.a_deg", "Move.b_deg", "Move.minutes"), (), (),
        "no table has such axes, or inverse time"),
    Owner(("Switch.number", "Switch.words", "Switch.does"), (), ("verify-sheet-tool",
        "verify-sheet-end", "verify-sheet-settings")),
    Owner(("Pause.seconds",), (), ("verify-sheet-tool",), _WAITS),
    Owner(("Compensation.side", "Compensation.radius"), (), ("verify-sheet-tool",
        "verify-sheet-side", "verify-sheet-compensation", "verify-sheet-band",
        "verify-sheet-extra")),
    Owner(("Acceleration.braking", "Acceleration.mm_s2"), (), ("verify-sheet-ramp",)),
    Owner(("Blending.distance",), (), ("verify-sheet-corner",)),
    Owner(("Lift.rapid", "Lift.start", "Lift.end", "Lift.feed_mm_min", "Touch.height",
        "Touch.feed_mm_min", "Zero.shifted"), (), ("verify-sheet-height",)),
    Owner(("Output.name", "Output.on", "Output.with_move"), (), ("verify-sheet-thc",
        "verify-sheet-output", "verify-sheet-dark")),
    Owner(("FeedShare.share",), (), ("verify-sheet-feed", "verify-sheet-output")),
    Owner(("ToolOffset.number",), (), ("verify-sheet-output",)),
    Owner(("Material.values",), (), ("verify-sheet-material",)),
    Owner(("Lettering.kind", "Lettering.text", "Lettering.values"), (), (),
        "no table has a stamp or printer"),
)  # fmt: skip

OWNERS: dict[tuple[Stock, Language], tuple[Owner, ...]] = {
    ("sheet", "codesys"): _CODESYS, ("sheet", "linuxcnc"): (*_LINUXCNC, *_OF_CODES),
    ("sheet", "grbl"): _GRBL, ("sheet", "mach3"): (*_MACH3, *_HELD),
    ("sheet", "events"): _EVENTS,
}  # fmt: skip
