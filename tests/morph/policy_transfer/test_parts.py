from __future__ import annotations

import numpy as np
import pytest

from morph.alignment.maps.affine_map import AffineMap
from morph.body.load import load
from morph.policy_transfer.body import body
from morph.policy_transfer.parts import Arrow, BodyNames, Spreads, names_of, parts
from morph.task.tasks import task

SOURCE = BodyNames(body="s", state=("slide", "hinge"), command=("push",), shown=2)
TARGET = BodyNames(body="t", state=("board", "ankle", "hip"), command=("wheel", "knee"), shown=3)


def affine(state: np.ndarray, action: np.ndarray) -> AffineMap:
    (n_s, n_t), (k_t, k_s) = state.shape, action.shape
    return AffineMap(
        state_law=state,
        state_shift=np.zeros(n_s),
        lift_law=np.linalg.pinv(state),
        lift_shift=np.zeros(n_t),
        action_law=action,
        action_state=np.zeros((k_t, n_t)),
        action_shift=np.zeros(k_t),
        read_law=np.linalg.pinv(action),
        read_state=np.zeros((k_s, n_t)),
        read_shift=np.zeros(k_s),
    )


def spreads(state: list[float], command: list[float]) -> Spreads:
    return Spreads(state=np.array(state), command=np.array(command))


def told(arrows: tuple[Arrow, ...]) -> list[tuple[str, str, float]]:
    return [(each.begin, each.end, round(each.weight, 9)) for each in arrows]


def test_arrows_are_shares_in_spreads_with_their_signs() -> None:
    found = affine(np.array([[0.0, 0.0, 2.0], [3.0, -0.5, 0.0]]), np.array([[2.0], [0.0]]))
    there = parts(found, SOURCE, TARGET, spreads([1, 1], [1]), spreads([0.1, 1.8, 1], [4, 1]))
    # Of the hinge, in spreads: 3 * 0.1 = 0.3 of the board and -0.5 * 1.8 = -0.9 of the ankle.
    assert told(there.states) == [
        ("hip", "slide", 1.0),
        ("ankle", "hinge", -0.75),
        ("board", "hinge", 0.25),
    ]
    assert told(there.commands) == [("push", "wheel", 1.0)]
    assert there.lost == ()


def test_a_part_below_a_tenth_plays_no_role_and_is_named() -> None:
    found = affine(np.array([[1.0, 0.0, 0.0], [0.05, 1.0, 0.0]]), np.array([[1.0], [1.0]]))
    there = parts(found, SOURCE, TARGET, spreads([1, 1], [1]), spreads([1, 1, 1], [1, 1]))
    assert [(a.begin, a.end) for a in there.states] == [("board", "slide"), ("ankle", "hinge")]
    assert there.lost == ("hip",)


def test_what_never_moved_counts_in_its_own_unit() -> None:
    found = affine(np.array([[1.0, 0.0, 1.0], [0.0, 1.0, 0.0]]), np.array([[1.0], [1.0]]))
    there = parts(found, SOURCE, TARGET, spreads([1, 1], [0]), spreads([1, 1, 0], [1, 0]))
    assert [a.weight for a in there.states] == pytest.approx([0.5, 0.5, 1.0])


def test_the_numbers_of_a_body_are_its_joints_and_their_speeds() -> None:
    named = names_of(body(task("balance", load("cartpole"))))
    assert named.state == ("slide", "hinge", "speed of slide", "speed of hinge")
    assert (named.command, named.shown, named.body) == (("slide",), 2, "cartpole")
