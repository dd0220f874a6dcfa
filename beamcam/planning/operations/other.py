"""Features that no line makes: bends, planes in space, cambers."""

from beamcam.errors import Diagnostic
from beamcam.model.part import Bend, Camber, EndPlane
from beamcam.planning import rules
from beamcam.planning.operations.bench import Bench
from beamcam.planning.operations.kind import Kind

NAMES = {Bend: "a bend", EndPlane: "an end plane", Camber: "a camber"}


def _needs(feature: Bend | EndPlane | Camber, _: Bench) -> Diagnostic:
    return rules.OTHER.at(feature.source, found=NAMES[type(feature)])


OTHER = Kind("other", lambda feature: type(feature) in NAMES, _needs)
