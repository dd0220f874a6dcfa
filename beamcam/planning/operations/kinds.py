"""The kinds of work on a bar; of a feature the first that makes it."""

from beamcam.model.part import Feature
from beamcam.planning.operations.contour import CONTOUR
from beamcam.planning.operations.hole import HOLE
from beamcam.planning.operations.kind import Kind
from beamcam.planning.operations.mark import LINE
from beamcam.planning.operations.other import OTHER
from beamcam.planning.operations.saw_cut import SAW_CUT
from beamcam.planning.operations.slot import SLOT
from beamcam.planning.operations.text import TEXT

KINDS = (HOLE, SLOT, LINE, CONTOUR, TEXT, OTHER, SAW_CUT)
REASONS = {code: said for kind in KINDS for code, said in kind.reasons.items()}


def kind_of(feature: Feature) -> Kind:
    """The kind of work that makes a feature."""
    for kind in KINDS:
        if kind.makes(feature):
            return kind
    raise TypeError(f"no kind of work makes a {type(feature).__name__}")
