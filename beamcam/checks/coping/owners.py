"""What answers for each word of a coper's program, and for each event that is made of it."""

from beamcam.checks import Language, Owner, Stock

_ON_THE_WAY = (
    "verify-coping-strikes", "verify-coping-limit", "verify-coping-torch", "verify-coping-angle",
    "verify-coping-square",
)  # fmt: skip
_CUT = (
    "verify-coping-hurt", "verify-coping-left", "verify-coping-gone", "verify-coping-holds",
    "verify-coping-extra", "verify-coping-place", "verify-coping-height", "verify-coping-air",
    "verify-coping-order", "verify-coping-passes", "verify-coping-zone",
)  # fmt: skip
_AGAIN = "says again what holds already, or what is said anew before it counts"
_FAR = "goes where nothing is in the way and nothing is cut"

_LINUXCNC = (
    Owner(("G0", "G1"), (), (*_ON_THE_WAY, *_CUT), "names no place, or where it is already"),
    Owner(("G0", "G1"), ("X", "Y", "Z", "A", "B"), (*_ON_THE_WAY, *_CUT), _FAR),
    Owner(("F",), (), ("verify-coping-feed",), "no cut follows"),
    Owner(("G2", "G3"), (), ("verify-arc", "verify-word", "verify-coping-torch")),
    Owner(("G2", "G3"), ("X", "Y", "Z", "A", "B", "I", "J"), ("verify-arc", "verify-word",
        "verify-coping-torch")),
    Owner(("G4",), (), ("verify-word",)),
    Owner(("G4",), ("P",), ("verify-coping-pierce", "verify-coping-torch"),
        "waits where the torch is off"),
    Owner(("G17", "G21", "G90", "G94", "G91.1"), (), (), _AGAIN),
    Owner(("G93",), (), ("verify-word", "verify-coping-feed"), "no move follows"),
    Owner(("G40",), (), (), "no compensation is on"),
    Owner(("G41.1", "G42.1"), (), ("verify-coping-torch",)),
    Owner(("G41.1", "G42.1"), ("D",), ("verify-coping-torch",)),
    Owner(("G61", "G61.1"), (), (), "each move ends where it stops"),
    Owner(("G64",), (), ("verify-coping-torch",)),
    Owner(("G64",), ("P", "Q"), ("verify-coping-torch",), "within the tolerance of paths"),
    Owner(("G73", "G81", "G82", "G83"), (), (*_ON_THE_WAY, "verify-word", "verify-setting")),
    Owner(("G73", "G81", "G82", "G83"), ("X", "Y", "Z", "A", "B", "R"), (*_ON_THE_WAY, *_CUT,
        "verify-word", "verify-setting"), _FAR),
    Owner(("G73", "G83"), ("Q",), ("verify-word",), _FAR),
    Owner(("G82",), ("P",), ("verify-word", "verify-coping-torch"), _FAR),
    Owner(("G80",), (), ("verify-word",), "no cycle holds"),
    Owner(("G91",), (), (*_ON_THE_WAY, *_CUT, "verify-word"), "no move follows"),
    Owner(("G98", "G99"), (), (), "no cycle holds, or the moves are judged themselves"),
    Owner(("M2", "M30"), (), ("verify-end", "verify-word")),
    Owner(("M3", "M4", "M5"), (), ("verify-coping-torch",), _AGAIN),
    Owner(("M3", "M4"), ("S",), ("verify-coping-torch",), _AGAIN),
    Owner(("M3", "M4", "M5"), ("$",), ("verify-coping-torch",)),
    Owner(("M6", "M7", "M8", "M9", "M62", "M63", "M64", "M65"), (), ("verify-coping-torch",)),
    Owner(("M6",), ("T",), ("verify-coping-torch",)),
    Owner(("M62", "M63", "M64", "M65"), ("P",), ("verify-coping-torch",)),
)  # fmt: skip

_EVENTS = (
    Owner(("Move.start", "Move.end", "Move.a_deg", "Move.b_deg"), (), (*_ON_THE_WAY, *_CUT), _FAR),
    Owner(("Move.feed_mm_min", "Move.minutes"), (), ("verify-coping-feed",)),
    Owner(("Move.own_feed",), (), (), "the feed that holds is looked at, wherever it is said"),
    Owner(("Switch.number", "Switch.words", "Switch.does"), (), ("verify-coping-torch",
        "verify-coping-measured")),
    Owner(("Pause.seconds",), (), ("verify-coping-pierce", "verify-coping-torch"),
        "waits where the torch is off, a minute at most"),
    Owner(("Compensation.radius",), (), (), "nothing keeps it where no side is asked for"),
    Owner(("Blending.distance",), (), ("verify-coping-torch",), "within the tolerance of paths"),
    Owner(("Move.rapid", "Move.curve", "Compensation.side", "Acceleration.braking",
        "Acceleration.mm_s2", "Lettering.kind", "Lettering.text", "Lettering.values", "Lift.rapid",
        "Lift.start", "Lift.end", "Lift.feed_mm_min", "Touch.height", "Touch.feed_mm_min",
        "Zero.shifted", "Output.name", "Output.on", "Output.with_move", "FeedShare.share",
        "ToolOffset.number", "Material.values"), (), ("verify-coping-torch",)),
)  # fmt: skip

OWNERS: dict[tuple[Stock, Language], tuple[Owner, ...]] = {
    ("profile", "linuxcnc"): _LINUXCNC, ("profile", "events"): _EVENTS,
}  # fmt: skip
