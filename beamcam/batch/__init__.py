"""Batches: many files in, a folder of programs and an account out.

    find -> run -> workers (here, processes, a cluster) -> rows

`find_inputs` says which files are meant, `run` posts them and gives a row for each.
"""

from beamcam.batch.find import FoundInputs, Input, find_inputs
from beamcam.batch.names import check_template
from beamcam.batch.pool import Here, Workers
from beamcam.batch.run import BatchError, run
from beamcam.batch.work import Shop

__all__ = [
    "BatchError", "FoundInputs", "Here", "Input", "Shop", "Workers", "check_template",
    "find_inputs", "run",
]  # fmt: skip
