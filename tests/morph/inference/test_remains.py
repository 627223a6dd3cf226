"""When what remains is taken for physics without a name."""

from __future__ import annotations

import pytest

from morph.inference.remains import MOST_UNKNOWN, NATS, SHARE, SMALL, STEEP, UNTOLD, Remains


def chance(*, share: float, nats: float) -> float:
    """Return the probability that physics is left."""
    return Remains(share=share, channels={}, nats=nats, in_noise=1.0).any_physics


def test_what_is_left_may_be_a_law_that_was_missed() -> None:
    left = Remains(share=1.0, channels={}, nats=1e6, in_noise=1.0)
    assert left.any_physics == pytest.approx(1.0, abs=1e-4)
    assert left.probability == MOST_UNKNOWN
    little = Remains(share=SHARE, channels={}, nats=NATS, in_noise=1.0)
    assert little.probability == little.any_physics


@pytest.mark.parametrize(
    ("named", "in_noise", "most"),
    [(True, 1.2, SMALL), (True, 2.0, MOST_UNKNOWN), (False, 1.2, MOST_UNKNOWN)],
)
def test_effects_that_predict_to_the_noise_leave_little(
    named: bool, in_noise: float, most: float
) -> None:
    left = Remains(share=1.0, channels={}, nats=1e6, in_noise=in_noise, named=named)
    assert left.probability == most


def test_at_the_thresholds_it_is_as_probable_as_not() -> None:
    assert chance(share=SHARE, nats=NATS) == pytest.approx(0.5)
    # The odds are the ratio to the nearer threshold, to the power `STEEP`.
    odds = 1.5**STEEP
    assert chance(share=1.5 * SHARE, nats=1e6) == pytest.approx(odds / (1.0 + odds))
    assert chance(share=1.0, nats=1.5 * NATS) == pytest.approx(odds / (1.0 + odds))


@pytest.mark.parametrize(
    ("share", "nats", "unknown"),
    [
        (0.5, 1.0, False),  # A force that readings do not ask for.
        (0.003, 1e5, False),  # What steps and sticking cost.
        (0.03, 1e3, True),
        (0.0, 0.0, False),
    ],
)
def test_a_force_must_be_more_than_rounding_and_sure(
    share: float, nats: float, unknown: bool
) -> None:
    assert (chance(share=share, nats=nats) > 0.5) == unknown


@pytest.mark.parametrize(
    ("named", "by_starts", "in_motion", "most"),
    [
        (False, 10.0, 0.1, MOST_UNKNOWN),
        (False, 60.0, 0.1, UNTOLD),
        (False, 10.0, 0.001, UNTOLD),
        (False, 10.0, 5.0, UNTOLD),
        (True, 10.0, 0.1, UNTOLD),
    ],
)
def test_in_contact_errors_count_beside_those_of_the_starts_and_the_motion(
    named: bool, by_starts: float, in_motion: float, most: float
) -> None:
    left = Remains(
        share=30.0, channels={}, nats=1e6, in_noise=100.0, named=named, touching=True,
        by_starts=by_starts, in_motion=in_motion,
    )  # fmt: skip
    assert left.probability == most
