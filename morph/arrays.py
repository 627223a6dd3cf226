"""The array types used everywhere."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
"""A float64 array; its shape stands in the docstring of whatever holds it."""

Mask = NDArray[np.bool_]
"""A boolean array."""

Integers = NDArray[np.int64]
"""An integer array."""

JSON = dict[str, Any]
"""What `json.loads` gives for an object."""
