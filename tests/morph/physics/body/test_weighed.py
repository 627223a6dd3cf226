"""Where a diagnosis looks for links that weigh other than described."""

from __future__ import annotations

import numpy as np
import pytest

from morph.body.load import load
from morph.body.spec import spec_of
from morph.physics.apply import apply
from morph.physics.body.com_offset import ComOffset
from morph.physics.body.link_inertia import LinkInertia
from morph.physics.body.payload import Payload


@pytest.mark.parametrize("kind", [LinkInertia, ComOffset, Payload])
def test_only_printed_links_that_move_are_suspected(kind: type[LinkInertia]) -> None:
    assert kind.suspects(load("double_pendulum")) == ()
    assert "jaw" in kind.suspects(load("so101"))
    assert "base" not in kind.suspects(load("so101"))
    assert "base" in kind.places(load("so101"))


def test_a_payload_is_not_scaled_with_the_link_whatever_the_order() -> None:
    # 0.5 * 0.64 kg + 0.1 kg = 0.42 kg; centre (0.32 * 0.2830844 + 0.1 * 0.1) / 0.42 m down.
    arm = load("double_pendulum")
    effects = (Payload(body="lower", m=0.1, z=-0.1), LinkInertia(body="lower", mass=0.5))
    for order in (effects, effects[::-1]):
        spec = spec_of(arm)
        apply(spec, order)
        body = spec.compile().body("lower")
        assert float(body.mass[0]) == pytest.approx(0.42, rel=1e-12)
        centre = -(0.32 * 0.2830843860488245 + 0.01) / 0.42
        np.testing.assert_allclose(body.ipos, [0.0, 0.0, centre], atol=1e-12)


def test_a_payload_adds_the_inertia_of_a_point() -> None:
    # About the hinge a point at r adds m r^2: 0.2 kg at 0.3 m, 0.018 kg m2.
    arm = load("double_pendulum")

    def about_hinge(*effects: Payload) -> float:
        spec = spec_of(arm)
        apply(spec, effects)
        body = spec.compile().body("lower")
        axes = np.empty(9)
        import mujoco

        mujoco.mju_quat2Mat(axes, body.iquat)
        turned = axes.reshape(3, 3) @ np.diag(body.inertia) @ axes.reshape(3, 3).T
        return float(turned[1, 1] + body.mass[0] * (body.ipos[0] ** 2 + body.ipos[2] ** 2))

    load_ = Payload(body="lower", m=0.2, x=0.3 * 0.6, z=-0.3 * 0.8)
    assert about_hinge(load_) - about_hinge() == pytest.approx(0.018, rel=1e-9)
