from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from morph.body.robot import Robot
from morph.errors import TransferError, TrialStopped
from morph.policy.policy import Policy
from morph.policy_transfer.link.fault_injection import Rough, Weather, pair
from morph.policy_transfer.link.offer import experience_of, experience_said
from morph.policy_transfer.link.online import OnlineRobot, Service
from morph.policy_transfer.link.policies import Policies
from morph.search.target import Experience, Target

STORM = Weather(down=0.3, lost=0.2, late=0.3, twice=0.3, spoilt=0.2)


class Hill(Target):
    """Costs how far a policy's bias is from 3; its position says which bias was tried."""

    def __init__(self) -> None:
        self.tried: list[float] = []
        self.stop: dict[str, Any] | None = None

    def trial(self, policy: Policy | Any, rng: np.random.Generator) -> Experience:
        bias = float(policy.weights()["bias"][0])
        self.tried.append(bias)
        shown = Experience(
            position=np.full((3, 2), float(len(self.tried))),
            velocity=np.zeros((3, 2)),
            command=np.full((2, 1), bias),
            period=0.05,
            loss=(bias - 3.0) ** 2,
            success=bias == 3.0,
        )
        if self.stop is not None:
            raise TrialStopped("too far", where="hill", fix="stay", shown=shown, **self.stop)
        return shown


def towards(linear: Any) -> Any:
    """Return a service's search: one more than the best bias so far, up to 3."""

    def improve(found: list[Experience]) -> Policy | None:
        best = min(found, key=lambda each: each.loss)
        bias = float(best.command[0, 0])
        return linear(bias + 1.0) if bias < 3.0 else None

    return improve


@pytest.mark.parametrize("seed", [100, 101])
def test_a_policy_improves_over_a_link_that_is_often_down_and_no_trial_is_lost(
    cartpole: Robot, linear: Any, posted: Any, tmp_path: Path, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    here, there = (Rough(end, STORM, rng) for end in pair())
    robot_post = posted(here, tmp_path / "a", "robot")
    service_post = posted(there, tmp_path / "b", "service")
    hill = Hill()
    online = OnlineRobot(hill, robot_post, Policies(tmp_path / "p", cartpole, linear(0.0)))
    service = Service(service_post, cartpole, towards(linear))
    trials = 0
    for _ in range(400):
        if trials < 30:
            online.trial(rng)
            trials += 1
        online.exchange()
        service.serve()
        if trials == 30 and robot_post.pending == service_post.pending == 0:
            break
    # Every trial arrived once, whatever its order.
    numbers = sorted(int(each.position[0, 0]) for each in service.experiences)
    assert numbers == list(range(1, 31))
    assert hill.tried[0] == 0.0
    assert set(hill.tried) <= {0.0, 1.0, 2.0, 3.0}
    assert hill.tried[-1] == 3.0
    # No spoilt policy was ever offered to be used: they did not get that far.
    assert [why for why in service.refused if "was offered already" not in why] == []


def test_without_a_service_trials_go_on_with_the_safe_policy(
    cartpole: Robot, linear: Any, posted: Any, tmp_path: Path
) -> None:
    rng = np.random.default_rng(100)
    post = posted(Rough(pair()[0], Weather(down=1.0), rng), tmp_path / "q", "robot")
    hill = Hill()
    online = OnlineRobot(hill, post, Policies(tmp_path / "p", cartpole, linear(0.5)))
    for _ in range(5):
        online.trial(rng)
    assert hill.tried == [0.5] * 5
    assert post.pending == 5


@pytest.mark.parametrize(
    ("stop", "after"), [({"beyond": True}, 0.0), ({"pressed": True}, 1.0), ({}, 1.0)]
)
def test_only_a_policy_that_went_beyond_a_limit_is_withdrawn(
    cartpole: Robot, linear: Any, posted: Any, tmp_path: Path, stop: dict[str, Any], after: float
) -> None:
    rng = np.random.default_rng(100)
    here, there = pair()
    robot = posted(here, tmp_path / "a", "robot")
    service = Service(posted(there, tmp_path / "b", "service"), cartpole, towards(linear))
    hill = Hill()
    online = OnlineRobot(hill, robot, Policies(tmp_path / "p", cartpole, linear(0.0)))
    online.trial(rng)
    service.serve()
    online.exchange()
    hill.stop = stop
    with pytest.raises(TrialStopped, match=r"too far"):
        online.trial(rng)
    hill.stop = None
    online.trial(rng)
    # The second was tried with the offered policy, and the third with what is safe after it.
    assert hill.tried == [0.0, 1.0, after]
    service.serve()
    # What the stopped trial showed arrived too.
    assert len(service.experiences) == 3


def test_an_experience_comes_out_as_it_went_in() -> None:
    shown = Hill().trial(
        type("P", (), {"weights": lambda self: {"bias": np.array([0.1])}})(),
        np.random.default_rng(0),
    )
    again = experience_of(experience_said(shown, version=1))
    for name in ("position", "velocity", "command"):
        np.testing.assert_array_equal(getattr(again, name), getattr(shown, name))
    assert (again.period, again.loss, again.success) == (0.05, shown.loss, False)


@pytest.mark.parametrize(
    "changed",
    [
        {"position": [[0.0]]},
        {"position": "x"},
        {"velocity": [[float("nan")] * 2] * 3},
        {"command": [[1.0]] * 3},
        {"period_s": 0.0},
        {"loss": None},
    ],
)
def test_an_experience_that_is_none_is_refused(changed: dict[str, Any]) -> None:
    said = experience_said(
        Experience(
            position=np.zeros((3, 2)),
            velocity=np.zeros((3, 2)),
            command=np.zeros((2, 1)),
            period=0.05,
            loss=1.0,
            success=False,
        ),
        version=1,
    )
    assert experience_of(said).loss == 1.0
    with pytest.raises(TransferError, match=r"an experience: it"):
        experience_of({**said, **changed})
