"""How the faces lie on paper: from where each is seen, which way its y runs, what it is called.

    h   y ^        seen through the web from the front: x to the right as on v, y up
    o   y v        from above, y = 0 at the far edge, which is the upper one: o unfolds over v
    v   y ^        from the front, y = 0 at the lower edge
    u   y ^        from below, y = 0 at the lower edge, the far one again

y of o and u counts from the h side (DSTV, pages 7 and 8), so that the edge of either flange that
meets v has y = the flange's width. x runs to the right on all of them.
"""

from beamcam.model.part import MIRRORED_FACES, Face

FACE_NAMES = {"h": "web", "o": "top flange", "v": "web", "u": "bottom flange"}
THROUGH = "h"  #: drawn through the steel, so that its x runs as on the others
#: From where a face is seen, and which edge of its view is y = 0.
SEEN = {
    "h": ("from behind, drawn through the web", "lower"),
    "o": ("from above", "upper"),
    "v": ("from the front", "lower"),
    "u": ("from below", "lower"),
}


def runs_down(face: Face) -> bool:
    """Whether y runs down the paper: numbers are mirrored seen from outside, and so is the view.

    h is mirrored too, and is drawn through the web instead.
    """
    return face in MIRRORED_FACES and face != THROUGH


def face_title(face: Face, code: str) -> str:
    """What a view shows, from where it is seen, and which of its edges is y = 0."""
    if face not in FACE_NAMES:
        return f"{face}   plane"
    name, (seen, edge) = FACE_NAMES[face], SEEN[face]
    if code == "B":
        name = "front" if face == "v" else "back"
        seen = "seen from the front" if face == "v" else "drawn through the plate"
    return f"{face}   {name}, {seen}; y = 0 is the {edge} edge"
