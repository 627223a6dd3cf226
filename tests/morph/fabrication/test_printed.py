from __future__ import annotations

import mujoco
import numpy as np
import pytest

from morph.body.load import load
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.errors import MakeError
from morph.fabrication.link_mass import LinkMass
from morph.fabrication.printed import designed, printed_robot
from morph.print.weight import Weight, box


@pytest.fixture(scope="module")
def arm() -> Robot:
    return load("so101")


def turned(angle: float) -> np.ndarray:
    pose = np.eye(4)
    pose[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    pose[:3, 3] = (10.0, -20.0, 30.0)
    return pose


def told(link: str, weight: Weight, before: Weight) -> LinkMass:
    return LinkMass(link=link, designed=before, predicted=weight, measured=None, source="gcode")


def test_mujoco_finds_the_mass_centre_and_inertia_that_a_link_was_given(arm: Robot) -> None:
    weight = box(0.071, np.array([60.0, 20.0, 30.0])).moved(turned(0.4))
    before = designed(arm)["upper_arm"]
    model = spec_of(printed_robot(arm, [told("upper_arm", weight, before)])).compile()
    at = model.body("upper_arm").id
    turn = np.empty(9)
    mujoco.mju_quat2Mat(turn, model.body_iquat[at])
    axes = turn.reshape(3, 3)
    found = axes @ np.diag(model.body_inertia[at]) @ axes.T
    assert model.body_mass[at] == 0.071
    # The com: 10, -20, 30 mm. Numbers are written with 17 digits and turned twice: 1e-15.
    np.testing.assert_allclose(model.body_ipos[at], (0.010, -0.020, 0.030), atol=1e-15)
    np.testing.assert_allclose(found, weight.inertia, atol=1e-15 * 10)


def test_links_that_are_not_named_keep_their_masses(arm: Robot) -> None:
    before = designed(arm)
    after = printed_robot(arm, [told("jaw", before["jaw"].scaled(0.02), before["jaw"])])
    for link in after.links:
        mass = 0.02 if link.name == "jaw" else before[link.name].mass
        assert link.mass == pytest.approx(mass, rel=1e-12)
    assert after.sha256 != arm.sha256


def test_a_scale_comes_before_a_prediction_and_a_description_changes_nothing(arm: Robot) -> None:
    before = designed(arm)["jaw"]
    mass = LinkMass(
        link="jaw",
        designed=before,
        predicted=before.scaled(0.02),
        measured=before.scaled(0.03),
        source="scale",
    )
    assert printed_robot(arm, [mass]).link("jaw").mass == pytest.approx(0.03, rel=1e-12)
    still = LinkMass(
        link="jaw", designed=before, predicted=None, measured=None, source="description"
    )
    assert printed_robot(arm, [still]).link("jaw").mass == arm.link("jaw").mass


def test_a_link_that_is_not_there_and_an_inertia_that_no_body_has_are_refused(arm: Robot) -> None:
    before = designed(arm)["jaw"]
    with pytest.raises(MakeError, match=r"there is no link 'claw'"):
        printed_robot(arm, [told("claw", before, before)])
    # The longest moment may not exceed the sum of the two others.
    odd = Weight(mass=0.1, com=np.zeros(3), inertia=np.diag([1e-5, 1e-5, 3e-5]))
    with pytest.raises(MakeError, match=r"an inertia that no body has"):
        printed_robot(arm, [told("jaw", odd, before)])
