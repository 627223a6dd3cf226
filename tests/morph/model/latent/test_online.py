"""Hidden parameters, sample after sample."""

from __future__ import annotations

import numpy as np
import pytest

from morph.body.robot import Robot
from morph.errors import DiagnosisError
from morph.model.latent.online import OnlineInference, hidden
from morph.model.latent.unknowns import turned

NOISE = np.full(4, 0.01)
MEMBERS = [{"length:pole": 0.7, "weight:pole": 1.0}, {"length:pole": 1.4, "weight:pole": 1.5}]


def test_a_hidden_parameter_has_the_members_mean_and_spread(cartpole: Robot) -> None:
    found = hidden(cartpole, MEMBERS, step=0.01)
    # Of two logarithms a and b: mean (a + b) / 2, deviation |a - b| / sqrt(2).
    widths = {knob.name: knob.fraction for knob in found.knobs}
    assert widths["length:pole"] == pytest.approx(np.log(2.0) / np.sqrt(2.0))
    assert widths["weight:pole"] == pytest.approx(np.log(1.5) / np.sqrt(2.0))
    assert f"length:pole*{np.sqrt(0.7 * 1.4):.4g}" in found.robot.name


def test_a_hundred_and_twenty_samples_tell_a_pole_of_another_length(cartpole: Robot, shown) -> None:
    truth = {"length:pole": 1.25, "weight:pole": 1.3}
    middle = {"length:pole": np.sqrt(0.7 * 1.4), "weight:pole": np.sqrt(1.5)}
    online = OnlineInference(
        hidden(cartpole, MEMBERS, step=0.01), NOISE, 0.05, integrator="rk4", every=30
    )
    widths = []
    for seed in (21, 22):
        run = shown(turned(cartpole, truth), seed=seed)
        # Each run is a life of its own: what is known goes on, what was seen does not.
        online = _anew(online)
        for state, command in zip(run.state[:-1], run.command, strict=True):
            known = online.see(state, command)
            if known is not None:
                widths.append(float(np.sqrt(known.covariance[0, 0])))
    assert known is not None
    found = {
        name: float(np.exp(x)) * middle[name]
        for name, x in zip(known.names, known.point, strict=True)
    }
    # Deviations of the logarithms here are below 0.01 and 0.03: five of them.
    assert found["length:pole"] == pytest.approx(1.25, rel=0.05)
    assert found["weight:pole"] == pytest.approx(1.3, rel=0.15)
    assert widths[-1] < 0.5 * np.log(2.0) / np.sqrt(2.0)


def _anew(online: OnlineInference) -> OnlineInference:
    fresh = OnlineInference(online.hypothesis, NOISE, 0.05, integrator="rk4", every=30)
    fresh.known = online.known
    return fresh


def test_nothing_is_known_before_the_first_samples(cartpole: Robot) -> None:
    online = OnlineInference(hidden(cartpole, MEMBERS, step=0.01), NOISE, 0.05)
    assert online.see(np.zeros(4), np.zeros(1)) is None


def test_members_that_differ_in_nothing_are_refused(cartpole: Robot) -> None:
    with pytest.raises(DiagnosisError, match="2 members differ in nothing"):
        hidden(cartpole, [{"length:pole": 1.0}, {"length:pole": 1.0}], step=0.01)
