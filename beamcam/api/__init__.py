"""beamcam from Python: read a part, plan the work, post the program, verify any program.

    import beamcam

    reading = beamcam.read("samples/dstv/channel.nc1")
    posted = beamcam.post(reading.parts, "beamline")
    assert not beamcam.verify(posted.text, reading.parts, "beamline")
    print(posted.text)

    jobs        read, load, convert, plan, post, rest, verify
    results     simulate, diff, recover, plot, report
    shop_lists  lists, labels

These functions and what they give back are stable. A machine is everywhere the name of a shipped
one, the path of a TOML file, or a `Machine`; `load` gives one as a job wants it. A file is its
path, its bytes, or open; a text is a path to `read`, and to all others the program itself. What
cannot be done raises a `BeamcamError` that carries its diagnostics, an `AskError` where the call is
wrong by itself; what is only to be said comes back as diagnostics beside the result. All of them
may be called from several threads at once; what they give and raise can be pickled.
"""

from beamcam.api.jobs import convert, load, plan, post, read, rest, verify
from beamcam.api.results import diff, plot, recover, report, simulate
from beamcam.api.shop_lists import labels, lists

__all__ = [
    "convert", "diff", "labels", "lists", "load", "plan", "plot", "post", "read", "recover",
    "report", "rest", "simulate", "verify",
]  # fmt: skip
