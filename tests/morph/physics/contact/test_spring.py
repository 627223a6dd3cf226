"""The restitution of a spring and damper, against integrating its motion."""

from __future__ import annotations

import pytest
from scipy.integrate import solve_ivp

from morph.physics.contact.spring import ratio_of, restitution_of


@pytest.mark.parametrize("ratio", [0.0, 0.1, 0.4, 0.7, 0.72, 0.999, 1.0, 1.001, 2.0, 5.0])
def test_the_restitution_is_that_of_the_motion_until_the_force_ends(ratio: float) -> None:
    # x'' = -x - 2 z x' with w = 1, from depth 0 at speed 1, until x + 2 z x' = 0.
    def force(_: float, state: list[float]) -> float:
        return state[0] + 2.0 * ratio * state[1]

    force.terminal, force.direction = True, -1.0  # type: ignore[attr-defined]
    out = solve_ivp(
        lambda t, s: [s[1], -force(t, s)],
        (0.0, 100.0),
        [0.0, 1.0],
        events=force,
        rtol=1e-10,
        atol=1e-12,
    )
    assert restitution_of(ratio) == pytest.approx(-out.y_events[0][0][1], abs=1e-6)


@pytest.mark.parametrize("e", [0.01, 0.1, 0.1353, 0.3, 0.9, 1.0])
def test_the_ratio_for_a_restitution_gives_it_back(e: float) -> None:
    assert restitution_of(ratio_of(e)) == pytest.approx(e, abs=1e-9)
