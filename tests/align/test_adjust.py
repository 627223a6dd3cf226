"""What is added to a policy's commands, against a law that is known."""

from __future__ import annotations

import numpy as np
import pytest

from morph.alignment.adjust import adjustment
from morph.alignment.errors import SamplesError

TURNS = np.array([False, True])


def made(rows: int = 60):
    rng = np.random.default_rng(0)
    state, command = rng.normal(size=(rows, 2)), rng.uniform(-5.0, 5.0, (rows, 1))
    wanted = 0.8 * state[:, :1] + 0.3 * np.sin(state[:, 1:]) + 0.25 * command
    return state, command, wanted


def test_a_law_in_state_and_command_is_found() -> None:
    state, command, wanted = made()
    found = adjustment(state, command, command + wanted, TURNS)
    assert found(state, command) == pytest.approx(wanted, abs=0.01)
    # Beside b: the place, the angle's sine and cosine, the command.
    assert found.law[0] == pytest.approx([0.8, 0.3, 0.0, 0.25], abs=0.05)


def test_where_replicating_asks_for_nothing_nothing_is_added() -> None:
    state, command, _ = made()
    found = adjustment(state, command, command, TURNS)
    assert np.abs(found(3.0 * state, 2.0 * command)).max() < 1e-6


def test_far_beyond_what_was_seen_the_law_is_held() -> None:
    state, command, wanted = made()
    found = adjustment(state, command, command + wanted, TURNS)
    far = np.array([[1e6, 0.0]])
    # The law holds up to 1.5 times the greatest place that was seen.
    most = 0.8 * 1.5 * np.abs(state[:, 0]).max()
    assert found(far, np.zeros((1, 1))) == pytest.approx(most, rel=0.1)


def test_its_slope_is_that_of_finite_differences() -> None:
    state, command, wanted = made()
    found = adjustment(state, command, command + wanted + 0.5 * np.sin(command), TURNS)
    slope = found.sloped(state, command)[1][:, :, 0]
    step = 1e-5
    by = (found(state, command + step) - found(state, command - step)) / (2.0 * step)
    inside = np.abs(command[:, 0]) < 4.9
    # Weights of order 1e2: 1e-14 / 1e-5, and a third derivative of order 10 times 1e-10.
    assert slope[inside] == pytest.approx(by[inside], abs=1e-5)


def test_its_sign_can_be_turned() -> None:
    state, command, wanted = made()
    found = adjustment(state, command, command + wanted, TURNS)
    turned = found.times(-1.0)(state, command)
    assert turned == pytest.approx(-found(state, command), abs=1e-9)


def test_commands_of_other_shapes_are_refused() -> None:
    state, command, _ = made()
    with pytest.raises(SamplesError, match=r"shape \(60, 1\), those that replicate them \(59, 1\)"):
        adjustment(state, command, command[1:], TURNS)
