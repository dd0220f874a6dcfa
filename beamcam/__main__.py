"""`python -m beamcam`."""

from beamcam.cli import main

main(prog_name="beamcam")
