"""Reading an .nc1 file pays for no heavy library."""

import subprocess
import sys

SCRIPT = """
import sys
from beamcam.readers.dstv import read
from beamcam.writers.dstv import write
from beamcam.model.part_json import write as write_json
(part,) = read(open(sys.argv[1], "rb").read(), "plate.nc1").parts
assert write(part) and write_json(part)
print([name for name in ("numpy", "ezdxf", "ifcopenshell", "shapely") if name in sys.modules])
"""


def test_no_heavy_library_is_imported(request):
    sample = request.config.rootpath / "samples" / "dstv" / "plate.nc1"
    result = subprocess.run(
        [sys.executable, "-c", SCRIPT, str(sample)],
        capture_output=True,
        text=True,
        check=False,
        cwd=request.config.rootpath,
    )
    assert (result.stdout.strip(), result.stderr) == ("[]", "")
