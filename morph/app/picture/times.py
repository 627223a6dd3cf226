"""When pictures are taken."""

from __future__ import annotations

import numpy as np

from morph.arrays import Array, Integers


def nearest_samples(times: Array, rate: float) -> Integers:
    """Return the index of the sample nearest to each picture, shape (pictures,).

    Args:
        times: When samples were taken, s, shape (samples,).
        rate: Pictures a second.
    """
    # A picture that is due at the very end is taken, though rounding may put it beyond.
    pictures = int(float(times[-1] - times[0]) * rate + 1e-6) + 1
    due = times[0] + np.arange(pictures) / rate
    after = np.clip(np.searchsorted(times, due), 1, len(times) - 1)
    nearer_before = due - times[after - 1] <= times[after] - due
    return np.asarray(after - nearer_before, dtype=np.int64)
