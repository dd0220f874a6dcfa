"""The version of beamcam, as programs and pages say it."""

__version__ = "0.1.0"
