from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from morph.body.load import load
from morph.errors import PolicyError, SearchError, TransferError
from morph.policy.linear import Linear
from morph.policy.observing import Observer
from morph.policy.pattern import pattern
from morph.policy.store import load_policy, write_policy
from morph.policy_transfer.body import Body, body, linear_law
from morph.policy_transfer.policy_conversion import gain_of, law_of, stored
from morph.task.tasks import task


@pytest.fixture(scope="module", params=["cartpole", "rider_two_links_driven"])
def here(request: pytest.FixtureRequest) -> Body:
    return body(task("balance", load(request.param)))


def gains(here: Body) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(3)
    commands = len(here.bounds[0])
    return 0.1 * rng.normal(size=(commands, here.size)), 0.01 * rng.normal(size=commands)


def test_a_law_that_was_stored_is_the_same_law(here: Body, tmp_path: Path) -> None:
    gain, shift = gains(here)
    robot = here.task.robot
    write_policy(stored(here, gain, shift), tmp_path / "policy", robot)
    again = gain_of(here, load_policy(tmp_path / "policy", robot))
    # Central differences of 1e-4 are off by 1e-8 / 6 of a third derivative, here a sine's gain.
    assert again[0] == pytest.approx(gain, abs=1e-7)
    assert again[1] == pytest.approx(shift, abs=1e-12)


def test_it_commands_what_the_law_says_near_rest(here: Body) -> None:
    gain, shift = gains(here)
    x = 1e-3 * np.random.default_rng(4).normal(size=(5, here.size))
    q, v = here.place(x)
    policy = stored(here, gain, shift)
    seen = Observer(policy, here.task.robot, here.plant.model, len(x)).see(q, v)
    told = policy.act(seen, np.zeros(len(x))) - here.still.command
    # sin(1e-3) differs from 1e-3 by 2e-10.
    assert told == pytest.approx(linear_law(gain, shift)(x, np.zeros(len(x))), abs=1e-9)


def test_a_body_that_floats_is_told_the_same_as_by_the_law() -> None:
    floating = load("humanoid_skateboard")
    assert any(joint.kind == "free" for joint in floating.joints)
    here = _standing(floating)
    gain, shift = gains(here)
    x = 1e-4 * np.random.default_rng(5).normal(size=(3, here.size))
    again = law_of(here, stored(here, gain, shift))(x, np.zeros(3))
    # A quaternion's numbers are those of a half angle to second order: 1e-8 of gains near 0.1.
    assert again == pytest.approx(linear_law(gain, shift)(x, np.zeros(3)), abs=1e-7)


def test_what_sees_less_is_stored_as_what_sees_all(here: Body) -> None:
    sight = np.random.default_rng(6).normal(size=(2, here.size))
    less = replace(here, sight=sight)
    gain, shift = gains(less)
    whole = gain_of(here, stored(less, gain, shift))
    assert whole[0] == pytest.approx(gain @ sight, abs=1e-7)


def test_actuators_that_are_told_as_one_are_stored_each_by_itself(here: Body) -> None:
    together = np.ones((len(here.still.command), 1))
    one = replace(here, together=together)
    gain, shift = gains(one)
    whole, each = gain_of(here, stored(one, gain, shift))
    assert whole == pytest.approx(together @ gain, abs=1e-7)
    assert each == pytest.approx(np.repeat(shift, len(together)))
    assert gain_of(one, stored(one, gain, shift))[0] == pytest.approx(gain, abs=1e-7)


def test_a_policy_that_does_not_look_is_refused(here: Body) -> None:
    robot = here.task.robot
    blind = pattern(robot, {}, period=here.task.period)
    with pytest.raises(TransferError, match=r"does not look at the body"):
        gain_of(here, blind)


def test_a_policy_that_looks_back_is_refused(here: Body) -> None:
    policy = stored(here, *gains(here))
    first, *rest = policy.observation
    old = (replace(first, delay_s=here.task.period), *rest)
    with pytest.raises(TransferError, match=r"looks back in time"):
        gain_of(here, replace(policy, observation=old))


def test_another_control_period_is_refused(here: Body) -> None:
    policy = replace(stored(here, *gains(here)), period=0.05)
    with pytest.raises(SearchError, match=r"commands every 0.05 s"):
        gain_of(here, policy)


def test_the_policy_of_another_body_is_refused(here: Body, tmp_path: Path) -> None:
    other = "rider_rigid_driven"
    there = body(task("balance", load(other)))
    policy: Linear = stored(there, *gains(there))
    write_policy(policy, tmp_path / "policy", there.task.robot)
    with pytest.raises(PolicyError, match=r"rider_rigid_driven|body"):
        load_policy(tmp_path / "policy", here.task.robot)


def _standing(robot: object) -> Body:
    from morph.policy_transfer.rest_on_contacts import PERIOD
    from morph.search.regulator.rest import Rest
    from morph.search.trajectory.plant import Plant
    from morph.sim.start import started
    from morph.task.stand import stand

    what = replace(stand(robot, name="balance"), period=PERIOD)  # type: ignore[arg-type]
    plant = Plant(what.simulator(), what.period)
    q, v = started(what.robot, plant.model, what.start.position, {})
    still = Rest(position=q, velocity=0.0 * v, command=np.zeros(plant.model.nu))
    return body(what, still=still)
