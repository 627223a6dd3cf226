"""When what remains is taken for physics without a name."""

from __future__ import annotations

import pytest

from morph.inference.remains import ERROR, NATS, SHARE, SHOWN, STEEP, Remains


def chance(*, share: float, nats: float, in_noise: float) -> float:
    """Return the probability that physics without a name is left."""
    return Remains(share=share, channels={}, nats=nats, in_noise=in_noise).probability


def test_at_the_thresholds_it_is_as_probable_as_not() -> None:
    assert chance(share=SHARE, nats=NATS, in_noise=SHOWN) == pytest.approx(0.5)
    # The odds are the ratio to the nearest threshold, to the power `STEEP`.
    odds = 1.5**STEEP
    assert chance(share=1.5 * SHARE, nats=1e6, in_noise=9.0) == pytest.approx(odds / (1.0 + odds))


@pytest.mark.parametrize(
    ("share", "nats", "in_noise", "unknown"),
    [
        (0.5, 1e5, 1.0, False),  # A force of some moments, as of a push.
        (0.5, 1.0, 10.0, False),  # A force that readings do not ask for.
        (0.002, 1e5, 3.0 * ERROR, False),  # No force: rollouts began at the wrong state.
        (0.02, 1e5, 3.0 * SHOWN, True),
        (0.008, 1e5, 4.0 * ERROR, True),
        (0.0, 0.0, 0.0, False),
    ],
)
def test_a_force_must_be_large_sure_and_show(
    share: float, nats: float, in_noise: float, unknown: bool
) -> None:
    assert (chance(share=share, nats=nats, in_noise=in_noise) > 0.5) == unknown
