"""The arrays that flow between the stages, by what they hold."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Float32Array = NDArray[np.float32]
Int32Array = NDArray[np.int32]
IntArray = NDArray[np.int64]
IndexArray = NDArray[np.intp]
Int8Array = NDArray[np.int8]
BoolArray = NDArray[np.bool_]
Complex64Array = NDArray[np.complex64]
Image = NDArray[np.uint8]
