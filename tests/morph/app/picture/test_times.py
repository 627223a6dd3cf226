from __future__ import annotations

import numpy as np
import pytest

from morph.app.picture.times import nearest_samples


@pytest.mark.parametrize("step", [0.002, 0.0333, 0.2])
def test_each_picture_shows_the_sample_nearest_to_it(step: float) -> None:
    times = 3.0 + step * np.arange(50)
    found = nearest_samples(times, 30.0)
    due = 3.0 + np.arange(len(found)) / 30.0
    assert np.abs(times[found] - due).max() <= 0.5 * step + 1e-12
    # Less than a picture's time is left at the end.
    assert 0.0 <= times[-1] - due[-1] < 1.0 / 30.0


def test_a_film_of_five_seconds_has_a_picture_at_both_ends() -> None:
    found = nearest_samples(0.002 * np.arange(2501), 30.0)
    assert (len(found), found[0], found[-1]) == (151, 0, 2500)


def test_a_single_step_gives_at_least_one_picture() -> None:
    assert nearest_samples(np.array([0.0, 0.002]), 30.0).tolist() == [0]
