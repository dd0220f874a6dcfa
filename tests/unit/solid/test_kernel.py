"""The solid kernel: on one thread, so that a process that is forked has all that it needs."""

import subprocess
import sys
from pathlib import Path

import pytest

WORK = """
import os
from beamcam.solid.kernel import kernel
processors = os.sched_getaffinity(0)
m = kernel()
def work(): return (m.Manifold.sphere(10, 200) - m.Manifold.cube((15, 15, 15))).volume()
volume = work()
assert os.sched_getaffinity(0) == processors
assert len(os.listdir("/proc/self/task")) == 1, os.listdir("/proc/self/task")
child = os.fork()
if not child:
    os._exit(0 if work() == volume else 1)
assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
"""


@pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="no processes are forked here")
def test_it_starts_no_thread_that_a_forked_process_would_wait_for() -> None:
    done = subprocess.run([sys.executable, "-c", WORK], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
