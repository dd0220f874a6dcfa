"""A damaged model is refused with words, never with a trace, and loses no member in silence."""

from random import Random

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from beamcam.errors import Severity
from beamcam.readers.ifc import read
from tests.conftest import examples
from tests.property.ifc_builder import model_text, random_member

ENCODINGS = ("csg", "openings", "outline")


def text_of(encoding: str) -> str:
    random = Random(encoding)
    return model_text([random_member(random, encoding) for _ in range(2)], encoding, random)[0]


TEXTS = {encoding: text_of(encoding) for encoding in ENCODINGS}


@settings(max_examples=examples(30), deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(st.sampled_from(ENCODINGS), st.integers(0, 10**6), st.sampled_from(("drop", "null", "swap")))
def test_damage_is_told(encoding: str, place: int, how: str) -> None:
    lines = TEXTS[encoding].split("\n")
    data = [i for i, line in enumerate(lines) if line.startswith("#")]
    at = data[place % len(data)]
    name, _, rest = lines[at].partition("=")
    if how == "drop":
        del lines[at]
    elif how == "null":
        head, _, values = rest.partition("(")
        first, *others = values.split(",")
        del first
        lines[at] = f"{name}={head}({','.join(['$', *others])}" if others else lines[at]
    else:
        other = data[(place * 7 + 3) % len(data)]
        lines[at] = f"{name}={lines[other].partition('=')[2]}"
    found = read("\n".join(lines).encode(), "damaged.ifc")
    codes = [d.code for d in found.diagnostics]
    assert codes
    if "ifc-ledger" in codes:
        (said,) = [d.message for d in found.diagnostics if d.code == "ifc-ledger"]
        refused = int(said.split(" refused")[0].split()[-1])
        errors = [d for d in found.diagnostics if d.severity is Severity.ERROR]
        assert len({d.source.where for d in errors}) <= refused or refused == len(errors)
        assert len(found.parts) == int(said.split(" read")[0].split()[-1])


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_undamaged_models_are_read(encoding: str) -> None:
    assert len(read(TEXTS[encoding].encode(), "whole.ifc").parts) == 2
