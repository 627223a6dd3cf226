from __future__ import annotations

import numpy as np
import pytest

from morph.record.clock import clock_of


def test_one_late_sample_is_seen_in_the_jitter_and_not_in_the_period() -> None:
    clock = clock_of(np.array([0.0, 0.1, 0.2, 0.3, 0.7]))
    # The intervals are 0.1 three times and 0.4: median 0.1, mean 0.175, deviation sqrt(3) * 0.075.
    assert clock.rate == pytest.approx(10.0, rel=1e-9)
    assert clock.jitter == pytest.approx(np.sqrt(3.0) * 0.075, rel=1e-9)
    assert clock.longest == pytest.approx(0.4, rel=1e-9)
