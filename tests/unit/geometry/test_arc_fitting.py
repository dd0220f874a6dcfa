"""Chains of free curves as lines and arcs: the odd ones."""

import pytest

from beamcam.geometry.arc_fitting import fit_chains
from beamcam.geometry.curves import Bezier


def test_a_curve_that_goes_out_and_back_is_two_lines() -> None:
    there = Bezier(((80.0, 60.0), (90.0, 80.0), (80.0, 60.0)))
    (fit,) = fit_chains([(there,)], 0.01)
    assert fit[0].start == fit[-1].end == (80.0, 60.0)
    assert max(curve.bbox[3] for curve in fit) == pytest.approx(70.0, abs=0.01)
