"""Which shapes an effect on a contact means, and that effects share them in any order."""

from __future__ import annotations

from collections.abc import Callable
from itertools import permutations

import mujoco
import numpy as np
import pytest

from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.errors import EffectError
from morph.physics.contact.contact_friction import ContactFriction
from morph.physics.contact.contact_softness import ContactSoftness
from morph.physics.contact.pairs import pairs_of
from morph.physics.contact.restitution import Restitution
from morph.physics.effect import Effect
from morph.physics.world.ground import Ground
from morph.physics.world.ground_slope import GroundSlope
from morph.sim.simulator import Simulator

FLOOR = "any+floor"

TREE = """
<geom name="wall" type="box" size="1 1 0.1" pos="3 0 0" friction="0.3"/>
<body name="base" pos="0 0 0.5"><freejoint/><geom name="hull" size="0.1" mass="1" condim="4"/>
  <geom name="paint" size="0.1" mass="0" contype="0" conaffinity="0"/>
  <body name="arm" pos="0.3 0 0"><joint axis="0 1 0"/>
    <geom size="0.05" mass="0.1" friction="0.8 0.01 0.001" priority="2"/>
    <body name="tool" pos="0.3 0 0"><geom size="0.05" mass="0.1"/></body>
    <body name="hand" pos="0.2 0 0"><joint axis="0 0 1"/><geom size="0.04" mass="0.1"/></body>
  </body></body>
<body name="post" pos="5 0 0"><geom name="post" size="0.1" mass="1"/></body>"""


@pytest.fixture(scope="module")
def tree(made: Callable[..., Robot]) -> Robot:
    return made(TREE, '<contact><exclude body1="base" body2="hand"/></contact>')


def met(robot: Robot, contact: str) -> set[tuple[str, str]]:
    pairs = pairs_of(spec_of(robot), contact, "here")
    return {(pair.geomname1, pair.geomname2) for pair in pairs}


def test_a_contact_with_the_floor_is_with_every_shape_of_the_world(tree: Robot) -> None:
    assert met(tree, "base+floor") == {("hull", "wall"), ("hull", "floor")}


def test_any_link_that_can_touch_the_world_is_meant_and_no_other(tree: Robot) -> None:
    # The post stands still as the world does; the paint collides with nothing.
    assert len(met(tree, FLOOR)) == 8
    assert not {"post", "paint"} & {name for pair in met(tree, FLOOR) for name in pair}


@pytest.mark.parametrize(
    ("contact", "pairs"),
    [
        ("base+arm", 0),  # Parent and child.
        ("base+tool", 0),  # The tool is the arm's, without a joint between.
        ("arm+tool", 0),  # One rigid body.
        ("arm+hand", 0),
        ("tool+hand", 0),  # The hand's parent carries the tool.
        ("base+hand", 0),  # Excluded by the description.
        ("post+hand", 1),
    ],
)
def test_links_that_mujoco_keeps_from_colliding_get_no_pair(
    tree: Robot, contact: str, pairs: int
) -> None:
    assert len(met(tree, contact)) == pairs


def test_the_pairs_of_all_contacts_are_what_mujoco_lets_collide(tree: Robot) -> None:
    places = [place for place in ContactFriction.places(tree) if not place.startswith("any")]
    ours = {frozenset(pair) for place in places for pair in met(tree, place)}
    spec = spec_of(tree)
    Ground().edit(spec)
    for shape in spec.geoms:
        # Spheres of 20 m reach everything, so that only the rules decide.
        if shape.name not in {"wall", "floor"}:
            shape.size[0] = 20.0
            shape.name = shape.name or f"{shape.parent.name}.shape0"
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    theirs = {frozenset(model.geom(int(one)).name for one in pair) for pair in data.contact.geom}
    assert ours == theirs


@pytest.mark.parametrize("contact", ["base", "base+", "nobody+floor", "base+wall", "", "a+b+c"])
def test_a_contact_of_no_two_bodies_is_refused(tree: Robot, contact: str) -> None:
    with pytest.raises(EffectError, match="does not name two bodies"):
        pairs_of(spec_of(tree), contact, "here")


def test_a_link_whose_shape_is_named_floor_is_refused(made: Callable[..., Robot]) -> None:
    thing = made('<body name="a"><freejoint/><geom name="floor" size="0.1" mass="1"/></body>')
    with pytest.raises(EffectError, match="link a has a shape named floor"):
        Ground().edit(spec_of(thing))


@pytest.mark.parametrize(
    "looks",
    [
        "",
        'friction="0.3 0.1 0.2" condim="6" margin="0.01"',
        'solref="0.01 2" solimp="0.8 0.9" solmix="3"',
        'solref="-900 -40" friction="1.5"',
        'priority="1" solref="0.05 0.5" friction="0.2"',
        'priority="-1" condim="1" solref="0.05 0.5" gap="0.01"',
    ],
)
def test_a_pair_made_changes_nothing(made: Callable[..., Robot], looks: str) -> None:
    # The same contact, found once by MuJoCo's own mixing of two shapes and once as a pair.
    thing = made(
        '<geom type="box" size="1 1 0.1" pos="0 0 -0.1" friction="0.7"/>'
        f'<body name="a" pos="0 0 0.2"><freejoint/><geom size="0.1" mass="1" {looks}/></body>'
    )

    class Bare(ContactFriction):
        def edit(self, spec: object) -> None:
            assert len(pairs_of(spec, self.contact, "here")) == 2

    start = {"a.linear_velocity.x": 1.0}
    plain = Simulator(thing, (Ground(height=-5.0),)).run(seconds=0.6, speed=start)
    paired = Simulator(thing, (Ground(height=-5.0), Bare(contact=FLOOR))).run(
        seconds=0.6, speed=start
    )
    assert plain["a.linear_velocity.z"].max() > -0.5  # It has landed.
    for name in plain.channels:
        assert np.abs(plain[name] - paired[name]).max() < 1e-12


def test_effects_on_one_contact_may_come_in_any_order(tree: Robot) -> None:
    effects: tuple[Effect, ...] = (
        Ground(height=-0.2),
        GroundSlope(roll=0.1),
        ContactFriction(contact=FLOOR, mu=0.3),
        ContactSoftness(contact="base+floor", stiffness=3000.0, damping=7.0),
        Restitution(contact=FLOOR, e=0.4),
    )
    seen = set()
    for order in permutations(effects):
        model = Simulator(tree, order).model
        named = sorted(
            (model.geom(a).name, model.geom(b).name, *values)
            for a, b, *values in zip(
                model.pair_geom1,
                model.pair_geom2,
                *model.pair_friction.T.round(12),
                *model.pair_solref.T.round(6),
                *model.pair_solreffriction.T.round(6),
                *model.pair_solimp.T.round(12),
                strict=True,
            )
        )
        floor = model.geom("floor")
        seen.add((str(named), str(floor.pos), str(floor.quat), int(model.opt.cone)))
    assert len(seen) == 1


@pytest.mark.parametrize(
    "effect",
    [
        Ground(height=-1000.0),
        GroundSlope(),
        ContactFriction(contact=FLOOR),
        ContactSoftness(contact=FLOOR),
        Restitution(contact=FLOOR),
    ],
    ids=lambda effect: effect.name,
)
def test_a_neutral_effect_leaves_a_body_that_touches_as_it_was(tree: Robot, effect: Effect) -> None:
    assert effect.neutral() == effect
    plain = Simulator(tree, (Ground(),)).run(seconds=0.8)
    neutral = Simulator(tree, (Ground(), effect)).run(seconds=0.8)
    assert plain["base.position.z"].min() < 0.12  # It has landed.
    for name in plain.channels:
        assert np.array_equal(plain[name], neutral[name])


def test_a_floor_too_stiff_for_the_step_is_refused_with_the_step_it_needs(block: Robot) -> None:
    # 1 kg on 1e6 N/m: 1 / sqrt(k) = 1 ms for the spring; 4000 N s/m: 0.25 ms for the damper.
    for damping, needed in ((-1.0, r"at most 0\.001 s"), (4000.0, r"at most 0\.00025 s")):
        softness = ContactSoftness(contact=FLOOR, stiffness=1e6, damping=damping)
        with pytest.raises(EffectError, match=needed):
            Simulator(block, (Ground(), softness), step=0.002)
        assert Simulator(block, (Ground(), softness), step=0.0002).model.npair == 1
