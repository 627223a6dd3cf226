"""Support under what hangs over the very first layer."""

from __future__ import annotations

import manifold3d
import numpy as np
import pytest

from morph.print.estimate import spacing
from morph.print.printer import Profile, material, printer
from morph.print.settings import SUPPORT_SPACING_MM
from morph.print.support import DENSE_SPACING_MM, support_mm3


@pytest.fixture
def profile() -> Profile:
    return Profile(printer=printer("mk4"), material=material("pla"))


def test_what_hangs_over_the_first_layer_is_held_by_one_layer(profile: Profile) -> None:
    foot, plate = (manifold3d.CrossSection.square((side, side), True) for side in (10.0, 40.0))
    found = support_mm3([foot, plate, plate], profile)
    line = spacing(profile)
    dense = line / (line + DENSE_SPACING_MM)
    loose = line / (line + SUPPORT_SPACING_MM)
    # Held are 40^2 - 10^2 mm2. They lie on one layer, drawn loosely, and count twice as dense; it
    # is wider than what it holds by 1.5 and 0.5 mm, so that it is 44 mm wide at the most.
    held = 40.0**2 - 10.0**2
    extra = 2.0 * (dense - loose) * held
    low, high = extra + loose * held, extra + loose * 44.0**2
    assert profile.layer_mm * low <= found <= profile.layer_mm * high
    assert np.isclose(support_mm3([plate, plate, plate], profile), 0.0)
