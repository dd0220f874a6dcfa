"""What answers for each word of a bar's program, and for each event that is made of it.

`tests/test_bar_words.py` puts every word into every state of programs: what none of the codes of
its row refuses has to leave everything as it was, for the reason that stands there.
"""

from beamcam.checks import Language, Owner, Stock

_MADE = (
    "verify-hole-*", "verify-path*", "verify-cut-*", "verify-depth", "verify-tool",
    "verify-not-made", "verify-order", "verify-cut-off",
)  # fmt: skip
_ON_THE_WAY = (
    "verify-limit", "verify-stop-back", "verify-rapid", "verify-clearance", "verify-sideways",
    "verify-no-spindle", "verify-spindle-on", "verify-spindle-off", "verify-coolant",
    "verify-turn", "verify-no-feed", "verify-peck",
    "verify-tap", "verify-word", "verify-no-feed", "verify-spindle-idle",
)  # fmt: skip
_AGAIN = "says again what holds already, or what is said anew before it counts"

_OF_ALL = (
    Owner(("M3", "M4"), (), ("verify-turn", "verify-spindle-*", "verify-no-spindle",
        "verify-speed", "verify-word"), _AGAIN),
    Owner(("M3", "M4"), ("{speed}",), ("verify-speed", "verify-tap", "verify-word"),
        "within what the cutting data allow"),
    Owner(("M5",), (), ("verify-spindle-*", "verify-turn"), _AGAIN),
    Owner(("M7", "M8", "M9"), (), ("verify-coolant", "verify-word"), _AGAIN),
    Owner(("M2", "M30"), (), ("verify-end", "verify-word")),
    Owner(("choose",), (), (*_MADE, *_ON_THE_WAY, "verify-tool-change", "verify-no-tool",
        "verify-word"), _AGAIN),
    Owner(("choose",), ("{spindle}", "{diameter}", "{tool}", "{station}", "{pitch}"),
        (*_MADE, *_ON_THE_WAY, "verify-tool-change", "verify-no-tool", "verify-word",
        "verify-speed", "verify-feed*"), _AGAIN),
    Owner(("change",), (), ("verify-tool-change", "verify-stop-comment", "verify-spindle-on",
        "verify-coolant", "verify-sideways", "verify-word"), "brings a tool that is needed later"),
    Owner(("change",), ("{spindle}", "{diameter}", "{station}", "{tool}"), ("verify-tool-change",
        "verify-stop-comment", "verify-word"), "brings a tool that is needed later"),
    Owner(("saw",), (), ("verify-spindle-on", "verify-coolant", "verify-word", "verify-sideways",
        *_MADE)),
    Owner(("saw",), ("{angle}", "{tilt}"), ("verify-limit", "verify-saw-reach", *_MADE,
        "verify-word")),
    Owner(("saw",), ("{feed}",), ("verify-feed*", "verify-no-feed", "verify-word")),
    Owner(("section",), (), (), _AGAIN),
    Owner(("section",), ("{section}", "{width}", "{height}"), ("verify-section", "verify-word")),
    Owner(("other",), (), (), _AGAIN),
    Owner(("other",), ("{pitch}",), ("verify-tool", "verify-tap", "verify-feed*", "verify-word"),
        "only a tap has a pitch"),
    Owner(("text",), (), ("verify-text-extra", "verify-word")),
    Owner(("text",), ("{string}", "{y}", "{height}", "{angle}", "{face}"),
        ("verify-text", "verify-word")),
    Owner(("codes: none",), (), (), "the machine's file says that it does nothing"),
    Owner(("G0", "G1"), (), (*_MADE, *_ON_THE_WAY), "names no place, or where it is already"),
    Owner(("G0", "G1"), ("X", "Y", "Z"), (*_MADE, *_ON_THE_WAY),
        "goes where nothing is in the way and nothing is made"),
)  # fmt: skip

_CODESYS = (
    *_OF_ALL,
    Owner(("G0", "G1"), ("F",), ("verify-feed*", "verify-no-feed"),
        "each stroke has its own"),
    Owner(("G1",), ("E", "E-"), ("verify-word",), "no more than the axes' own"),
    Owner(("G2", "G3", "G6", "G8", "G9"), (), ("verify-arc", "verify-word")),
    Owner(("G2", "G3", "G6", "G8", "G9"), ("X", "Y", "Z", "F", "E", "E-", "I", "J"),
        ("verify-arc", "verify-word")),
    Owner(("G2", "G3", "G8", "G9"), ("R",), ("verify-arc", "verify-word")),
    Owner(("G8", "G9"), ("K",), ("verify-arc", "verify-word")),
    Owner(("G4",), (), ("verify-word",)),
    Owner(("G4",), ("T",), ("verify-word",), "waits where no tool is in the steel"),
    Owner(("G40",), (), (), "no compensation is on"),
    Owner(("G40",), ("D",), (), "a radius that nothing keeps"),
    Owner(("G41", "G42"), (), ("verify-word",)),
    Owner(("G41", "G42"), ("D",), ("verify-word",)),
    Owner(("G50", "G53"), (), (), "takes back what G51 to G55 said; a place that is another one "
        "then is refused itself"),
    Owner(("G51", "G52"), (), ("verify-word",)),
    Owner(("G51", "G52"), ("D",), ("verify-word",), "within the tolerance of paths"),
    Owner(("G54", "G55"), (), ("verify-word",)),
    Owner(("G54", "G55"), ("X", "Y", "Z"), (*_MADE, *_ON_THE_WAY, "verify-bar-start",
        "verify-bar-end", "verify-bar-left"), "no place is said behind it"),
    Owner(("G56", "M98", "M99"), (), ("verify-word",)),
    Owner(("G75",), (), (), "waits until what was read is done"),
    Owner(("G90",), (), (), _AGAIN),
    Owner(("G91",), (), (*_MADE, *_ON_THE_WAY, "verify-word"), "no move follows"),
    Owner(("G98", "G99"), (), (), "only arcs have a centre, and there are none"),
    Owner(("codes: drill-cycle", "codes: drill-cycle-dwell", "codes: drill-cycle-peck",
        "codes: drill-cycle-chips"), (), (*_MADE, *_ON_THE_WAY, "verify-word")),
    Owner(("codes: end-cycle",), (), (*_MADE, *_ON_THE_WAY), "no cycle holds"),
)  # fmt: skip

_LINUXCNC = (
    *_OF_ALL,
    Owner(("F",), (), ("verify-feed*", "verify-no-feed"),
        "each stroke has its own"),
    Owner(("G2", "G3"), (), ("verify-arc", "verify-word")),
    Owner(("G2", "G3"), ("X", "Y", "Z", "I", "J"), ("verify-arc", "verify-word")),
    Owner(("G4",), (), ("verify-word",)),
    Owner(("G4",), ("P",), ("verify-word",), "waits where no tool is in the steel"),
    Owner(("G17", "G21", "G90", "G94", "G91.1"), (), (), _AGAIN),
    Owner(("G40",), (), (), "no compensation is on"),
    Owner(("G41.1", "G42.1"), (), ("verify-word",)),
    Owner(("G41.1", "G42.1"), ("D",), ("verify-word",)),
    Owner(("G61", "G61.1"), (), (), "each move ends where it stops"),
    Owner(("G64",), (), ("verify-word",)),
    Owner(("G64",), ("P", "Q"), ("verify-word",), "within the tolerance of paths"),
    Owner(("G73", "G81", "G82", "G83"), (), (*_MADE, *_ON_THE_WAY, "verify-word",
        "verify-setting")),
    Owner(("G73", "G81", "G82", "G83"), ("X", "Y", "Z", "R"), (*_MADE, *_ON_THE_WAY,
        "verify-word", "verify-setting")),
    Owner(("G73", "G83"), ("Q",), ("verify-peck", "verify-word")),
    Owner(("G82",), ("P",), ("verify-word", "verify-word")),
    Owner(("G80",), (), (*_MADE, *_ON_THE_WAY, "verify-word"), "no cycle holds"),
    Owner(("G91",), (), (*_MADE, *_ON_THE_WAY, "verify-word"), "no move follows"),
    Owner(("G98", "G99"), (), (*_MADE, *_ON_THE_WAY), "no cycle holds, or the moves are the same"),
    Owner(("M3", "M4"), ("S",), ("verify-speed", "verify-word"), _AGAIN),
    Owner(("M3", "M4", "M5"), ("$",), ("verify-word",)),
    Owner(("M6",), (), ("verify-word",)),
    Owner(("M6",), ("T",), ("verify-word",)),
    Owner(("M62", "M63", "M64", "M65"), (), ("verify-word",)),
    Owner(("M62", "M63", "M64", "M65"), ("P",), ("verify-word",)),
)  # fmt: skip

_EVENTS = (
    Owner(("Move.rapid",), (), ("verify-rapid", "verify-clearance")),
    Owner(("Move.start", "Move.end"), (), (*_MADE, *_ON_THE_WAY)),
    Owner(("Move.feed_mm_min", "Move.own_feed"), (), ("verify-no-feed", "verify-feed*")),
    Owner(("Move.curve",), (), ("verify-word",)),
    Owner(("Move.a_deg", "Move.b_deg", "Move.minutes"), (), (), "no machine for bars has them"),
    Owner(("Switch.number", "Switch.words", "Switch.does"), (), ("verify-word",)),
    Owner(("Pause.seconds",), (), ("verify-word",), "a minute at most, no tool in the steel"),
    Owner(("Compensation.side",), (), ("verify-word",)),
    Owner(("Compensation.radius",), (), (), "nothing keeps it where no side is asked for"),
    Owner(("Blending.distance",), (), ("verify-word",), "within the tolerance of paths"),
    Owner(("Acceleration.braking", "Acceleration.mm_s2"), (), ("verify-word",),
        "no more than the axes' own"),
    Owner(("Lettering.kind", "Lettering.text", "Lettering.values"), (), ("verify-text*",)),
    Owner(("Lift.rapid", "Lift.start", "Lift.end", "Lift.feed_mm_min", "Touch.height",
        "Touch.feed_mm_min", "Zero.shifted", "Output.name", "Output.on", "Output.with_move",
        "FeedShare.share", "ToolOffset.number", "Material.values"), (), (),
        "only words of a table make one"),
)  # fmt: skip

OWNERS: dict[tuple[Stock, Language], tuple[Owner, ...]] = {
    ("beam", "codesys"): _CODESYS, ("beam", "linuxcnc"): _LINUXCNC, ("beam", "events"): _EVENTS,
}  # fmt: skip
