"""Names of array types: numbers, whole numbers and truth values, one of each kind for all rooms."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Counts = NDArray[np.int64]
Flags = NDArray[np.bool_]
