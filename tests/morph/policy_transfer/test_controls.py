from __future__ import annotations

import numpy as np

from morph.alignment.maps.affine_map import AffineMap
from morph.policy_transfer.controls import flipped, mixed, shuffled, through, turned

GAIN, SHIFT = np.array([[1.0, 10.0, 100.0, 1000.0]]), np.array([0.25])
Y = np.array([[1.0, 2.0, 3.0, 4.0]])
NOW = np.zeros(1)


def identity() -> AffineMap:
    four, one = np.eye(4), np.eye(1)
    return AffineMap(
        state_law=four,
        state_shift=np.zeros(4),
        lift_law=four,
        lift_shift=np.zeros(4),
        action_law=2.0 * one,
        action_state=np.zeros((1, 4)),
        action_shift=np.zeros(1),
        read_law=0.5 * one,
        read_state=np.zeros((1, 4)),
        read_shift=np.zeros(1),
    )


def test_through_a_map_the_source_is_told_what_it_knows() -> None:
    # 1 + 20 + 300 + 4000 and a quarter, twice by the map of actions.
    assert through(identity(), GAIN, SHIFT)(Y, NOW).tolist() == [[2.0 * 4321.25]]


def test_flipped_every_state_has_the_other_sign() -> None:
    assert flipped(identity(), GAIN, SHIFT)(Y, NOW).tolist() == [[2.0 * (0.25 - 4321.0)]]


def test_shuffled_a_joint_takes_its_speed_along() -> None:
    (law,) = shuffled(identity(), GAIN, SHIFT, 4, np.random.default_rng(0))
    # The only other order of two joints: 2 + 10 and 400 + 3000.
    assert law(Y, NOW).tolist() == [[2.0 * 3412.25]]


def test_one_joint_cannot_be_shuffled() -> None:
    assert shuffled(identity(), GAIN, SHIFT, 2, np.random.default_rng(0)) == ()


def test_no_shuffle_is_the_right_order() -> None:
    rng = np.random.default_rng(0)
    right = through(identity(), GAIN, SHIFT)(Y, NOW)
    for law in shuffled(identity(), GAIN, SHIFT, 4, rng):
        assert not np.array_equal(law(Y, NOW), right)


def test_a_map_that_is_turned_or_mixed_still_goes_there_and_back() -> None:
    for spoilt in (turned(identity()), mixed(identity())):
        assert spoilt.state(spoilt.state_back(Y)).tolist() == Y.tolist()
    assert turned(identity()).state(Y).tolist() == (-Y).tolist()
    assert mixed(identity()).state(Y).tolist() == [[2.0, 1.0, 4.0, 3.0]]
