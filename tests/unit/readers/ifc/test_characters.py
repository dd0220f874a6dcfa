"""What is found at many places of a text at once, as a loop over it finds it."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from beamcam.readers.ifc import characters
from beamcam.readers.ifc.characters import codes_of, holds, places_of

TEXTS = st.text("ab,;()/*", max_size=30)


@given(TEXTS, st.integers(1, 9))
def test_signs_are_found_in_every_stretch(text: str, stretch: int) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(characters, "STRETCH", stretch)
        found = places_of(codes_of(text), b",;)").tolist()
    assert found == [at for at, letter in enumerate(text) if letter in ",;)"]


@given(TEXTS)
def test_a_pair_is_found_wherever_it_begins(text: str) -> None:
    assert holds(codes_of(text), b"/*") == ("/*" in text)
