"""Types of arrays."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
"""Numbers."""

Mask = NDArray[np.bool_]
"""Which ones."""

Integers = NDArray[np.int64]
"""Counts and places."""
