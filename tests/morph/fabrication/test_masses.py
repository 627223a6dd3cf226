from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from morph.body.robot import Robot
from morph.fabrication.masses import link_masses
from morph.print.job import Job


def test_a_link_weighs_what_its_parts_do_about_their_common_centre(
    job: Job, pendulum: Robot
) -> None:
    link = pendulum.links[-1].name
    (mass,) = [each for each in link_masses(pendulum, job, {link}) if each.link == link]
    assert mass.source == "estimate"
    assert mass.predicted is not None
    # Two bars of 10 g at 0.4 and 0.6 m, a ball of 100 g at 0.5 m.
    assert mass.now.mass == pytest.approx(0.120, rel=1e-12)
    np.testing.assert_allclose(mass.now.com, (0, 0, -0.5), atol=1e-15)
    # 2 (m/12 (0.02^2 + 0.04^2) + m 0.1^2) + 0.1/12 (2 * 0.03^2).
    across = 2 * (0.01 / 12 * (0.02**2 + 0.04**2) + 0.01 * 0.1**2) + 0.1 / 6 * 0.03**2
    assert mass.now.inertia[0, 0] == pytest.approx(across, rel=1e-12)
    along = 2 * 0.01 / 6 * 0.02**2 + 0.1 / 6 * 0.03**2
    assert mass.now.inertia[2, 2] == pytest.approx(along, rel=1e-12)


def test_a_scale_scales_every_copy_of_a_part(job: Job, pendulum: Robot) -> None:
    link = pendulum.links[-1].name
    (mass,) = link_masses(pendulum, job, {link}, {"bar": 0.015})[-1:]
    assert mass.source == "scale"
    assert mass.now.mass == pytest.approx(0.130, rel=1e-12)
    assert mass.predicted is not None
    assert mass.predicted.mass == pytest.approx(0.120, rel=1e-12)


def test_of_a_link_that_is_not_whole_nothing_is_predicted(job: Job, pendulum: Robot) -> None:
    link = pendulum.links[-1].name
    bar, ball = job.parts
    refused = replace(job, parts=(ball,), refused=(bar,))
    unknown = replace(job, parts=(bar, replace(ball, weight=None)))
    for mass in (
        link_masses(pendulum, job, ())[-1],
        link_masses(pendulum, refused, {link})[-1],
        link_masses(pendulum, unknown, {link})[-1],
    ):
        assert mass.source == "description"
        assert mass.predicted is None
        assert mass.now.mass == pendulum.links[-1].mass
