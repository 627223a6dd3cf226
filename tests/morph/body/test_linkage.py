"""Closed chains against trigonometry, finite differences and MuJoCo's own constraint."""

from __future__ import annotations

import math
from typing import Any

import mujoco
import numpy as np
import pytest

from morph.arrays import Array
from morph.body.card import Closure
from morph.body.linkage import FourBar, close_chain, loop_residual
from morph.errors import RobotError

LENGTHS = {
    "crank-rocker": (0.10, 0.03, 0.09, 0.06),
    "double-crank": (0.03, 0.08, 0.09, 0.07),
    "rocker-crank": (0.10, 0.06, 0.09, 0.03),
    "double-rocker": (0.10, 0.08, 0.03, 0.07),
    "triple-rocker": (0.10, 0.05, 0.04, 0.06),
    "change-point": (0.10, 0.04, 0.10, 0.04),
}
"""Ground, crank, coupler and rocker, m; each kind by Grashof's sum, worked out by hand."""

# The open tree of a four-bar: the rocker at 0.1 m, crank and coupler from the left. At home
# the crank points up (0, 0.03), the coupler's end and the rocker's are at (0.08, 0.05).
TREE = """
<mujoco><option gravity="0 0 0" integrator="implicitfast"/><worldbody>
  <body name="crank"><joint name="crank" axis="0 -1 0" armature="1e-3"/>
    <geom type="capsule" fromto="0 0 0 0 0 0.03" size="0.003"/>
    <body name="coupler" pos="0 0 0.03"><joint name="coupler" axis="0 -1 0"/>
      <geom type="capsule" fromto="0 0 0 0.08 0 0.02" size="0.003"/>{coupler}</body></body>
  <body name="rocker" pos="0.1 0 0"><joint name="rocker" axis="{axis}"/>
    <geom type="capsule" fromto="0 0 0 -0.02 0 0.05" size="0.003"/>{rocker}</body>
</worldbody>
<default><geom contype="0" conaffinity="0" density="1000"/></default>
<actuator><position name="crank" joint="crank" kp="5" kv="0.1"/></actuator></mujoco>
"""
BODIES = ("rocker", "crank", "coupler")
PIN = (0.08, 0.0, 0.02)


def tree(coupler: str = "", rocker: str = "", axis: str = "0 -1 0") -> Any:
    return mujoco.MjSpec.from_string(TREE.format(coupler=coupler, rocker=rocker, axis=axis))


def four_bar(kind: str, branch: int = 1) -> FourBar:
    ground, crank, coupler, rocker = LENGTHS[kind]
    return FourBar(ground=ground, crank=crank, coupler=coupler, rocker=rocker, branch=branch)


def inside(bar: FourBar) -> Array:
    """Return crank angles at which it closes, away from the ends where it stalls."""
    return np.concatenate([np.linspace(a + 0.05, b - 0.05, 41) for a, b in bar.crank_range()])


@pytest.mark.parametrize("kind", LENGTHS)
def test_grashof_names_each_kind(kind: str) -> None:
    assert four_bar(kind).kind == kind


@pytest.mark.parametrize("branch", [1, -1])
@pytest.mark.parametrize("kind", LENGTHS)
def test_the_coupler_keeps_its_length_wherever_the_crank_may_stand(kind: str, branch: int) -> None:
    bar = four_bar(kind, branch)
    angle = inside(bar)
    rocker = bar.rocker_angle(angle)
    across = bar.ground + bar.rocker * np.cos(rocker) - bar.crank * np.cos(angle)
    up = bar.rocker * np.sin(rocker) - bar.crank * np.sin(angle)
    # Lengths of 0.1 m in doubles: 1e-17; an arc cosine within 0.05 rad of its end loses 1e-14.
    assert np.abs(np.hypot(across, up) - bar.coupler).max() < 1e-13


@pytest.mark.parametrize("kind", [kind for kind in LENGTHS if kind != "change-point"])
def test_a_crank_angle_outside_its_range_is_refused(kind: str) -> None:
    bar = four_bar(kind)
    allowed = bar.crank_range()
    turns = sum(high - low for low, high in allowed) > 2 * math.pi - 1e-9
    assert turns == (kind in ("crank-rocker", "double-crank"))
    for _, high in allowed if not turns else ():
        with pytest.raises(RobotError, match="does not close at a crank angle"):
            bar.rocker_angle(high + 1e-6)


def test_the_range_of_a_triple_rocker_ends_where_coupler_and_rocker_are_in_line() -> None:
    # Triangle of ground 0.10, crank 0.05 and coupler + rocker 0.10: the law of cosines gives
    # cos = (0.01 + 0.0025 - 0.01) / (2 * 0.1 * 0.05) = 0.25.
    (interval,) = four_bar("triple-rocker").crank_range()
    assert interval == pytest.approx((-math.acos(0.25), math.acos(0.25)), abs=1e-12)


def test_a_parallelogram_moves_its_rocker_as_its_crank() -> None:
    # Its opposite sides stay parallel, so the angles are equal and both ratios are 1.
    bar = four_bar("change-point", branch=1)
    angle = np.linspace(0.2, 2.9, 20)
    assert np.abs(bar.rocker_angle(angle) - angle).max() < 1e-12
    assert np.abs(bar.velocity_ratio(angle) - 1.0).max() < 1e-12
    across = np.abs(np.sin(angle))  # The coupler stays level: the angle is the rocker's own.
    assert np.abs(np.sin(bar.transmission_angle(angle)) - across).max() < 1e-12


@pytest.mark.parametrize("branch", [1, -1])
@pytest.mark.parametrize("kind", LENGTHS)
def test_the_ratios_are_those_of_finite_differences(kind: str, branch: int) -> None:
    bar, h = four_bar(kind, branch), 1e-6
    angle = inside(bar)
    angle = angle[np.sin(bar.transmission_angle(angle)) > 0.2]
    moved = bar.rocker_angle(angle + h) - bar.rocker_angle(angle - h)
    slope = ((moved + np.pi) % (2 * np.pi) - np.pi) / (2 * h)
    # Rounding 1e-15 / h = 1e-9, amplified by 1 / 0.2^2; truncation h^2 times a third
    # derivative of at most 1e4.
    assert np.abs(bar.velocity_ratio(angle) - slope).max() < 1e-7
    moving = np.abs(slope) > 0.05
    # Virtual work: what the crank's torque does, the rocker's does.
    work = bar.torque_ratio(angle)[moving] * slope[moving]
    assert np.abs(work - 1.0).max() < 1e-5


def test_a_four_bar_is_found_from_its_four_points() -> None:
    points = ((0.0, 0.0), (0.0, 0.03), (0.08, 0.05), (0.1, 0.0))
    bar = FourBar.of(*(np.array(point) for point in points))
    assert bar.ground == pytest.approx(0.1)
    assert bar.coupler == pytest.approx(math.hypot(0.08, 0.02))
    assert float(bar.rocker_angle(math.pi / 2)) == pytest.approx(math.atan2(0.05, -0.02), abs=1e-12)
    below = FourBar.of(*(np.array((x, -y)) for x, y in points))
    assert below.branch == -bar.branch


def test_lengths_that_can_never_close_are_refused() -> None:
    with pytest.raises(RobotError, match="close at no angle"):
        FourBar(ground=0.1, crank=0.02, coupler=0.02, rocker=0.02)


def swung(model: Any, target: float) -> Any:
    """Return the state in which MuJoCo holds the loop with its crank near a target."""
    data = mujoco.MjData(model)
    for step in range(3000):
        data.ctrl[0] = target * min(1.0, step / 1500)
        mujoco.mj_step(model, data)
    return data


@pytest.mark.parametrize("target", [-1.2, -0.5, 0.4, 0.9])
def test_the_simulated_chain_follows_the_closed_form(target: float) -> None:
    spec = tree()
    assert close_chain(spec, Closure(kind="four-bar", bodies=BODIES, pin=PIN), "card") in (
        equality.name for equality in spec.equalities
    )
    data = swung(spec.compile(), target)
    crank, _, rocker = data.qpos
    home = (np.array(p) for p in ((0.0, 0.0), (0.0, 0.03), (0.08, 0.05), (0.1, 0.0)))
    law = float(FourBar.of(*home).rocker_angle(math.pi / 2 + crank)) - math.atan2(0.05, -0.02)
    assert crank == pytest.approx(target, abs=0.01)
    # At rest and without load the pin has no force to give way to: 1e-6 rad is 5e-8 m.
    assert (rocker - law + math.pi) % (2 * math.pi) - math.pi == pytest.approx(0.0, abs=1e-6)


def test_torque_passes_through_the_simulated_chain_as_virtual_work_says() -> None:
    spec = tree()
    close_chain(spec, Closure(kind="four-bar", bodies=BODIES, pin=PIN), "card")
    model = spec.compile()
    data, load = mujoco.MjData(model), 0.02
    data.qfrc_applied[model.joint("rocker").qposadr[0]] = load
    for _ in range(4000):
        mujoco.mj_step(model, data)
    home = (np.array(p) for p in ((0.0, 0.0), (0.0, 0.03), (0.08, 0.05), (0.1, 0.0)))
    ratio = float(FourBar.of(*home).torque_ratio(math.pi / 2 + data.qpos[0]))
    # The servo holds the crank by load / ratio. The pin yields by micrometres: of 50 mm, 1e-4.
    assert data.actuator_force[0] == pytest.approx(-load / ratio, rel=1e-3)


def test_a_residual_of_hinges_is_the_gap_that_mujoco_sees() -> None:
    # Cut at the pin: from the rocker's side up to the ground, and down crank and coupler.
    model = tree('<site name="a" pos="0.08 0 0.02"/>', '<site name="b" pos="-0.02 0 0.05"/>')
    compiled = model.compile()
    data, rng = mujoco.MjData(compiled), np.random.default_rng(3)
    axes = np.array([[0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, -1.0, 0.0]])
    anchors = np.array([[0.1, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.03]])
    pin = np.array([0.08, 0.0, 0.05])
    for crank, coupler, rocker in rng.normal(size=(20, 3)):
        data.qpos[:] = crank, coupler, rocker
        mujoco.mj_kinematics(compiled, data)
        gap = data.site("a").xpos - data.site("b").xpos
        residual = loop_residual(axes, anchors, np.array([rocker, crank, coupler]), pin)
        # The residual is seen from the rocker, a turn that keeps its length.
        assert np.linalg.norm(residual) == pytest.approx(np.linalg.norm(gap), abs=1e-15)
    assert np.abs(loop_residual(axes, anchors, np.zeros(3), pin)).max() < 1e-16


@pytest.mark.parametrize("pin", [{"pin": PIN}, {"pin_on_first": (-0.02, 0.0, 0.05)}, {}])
def test_the_pin_is_where_the_card_or_the_geometry_says(pin: dict[str, Any]) -> None:
    # Frames on fixed joints, as URDF has them: one on each side, and one that leads astray.
    spec = tree(
        '<body name="tip" pos="0.08 0 0.02"/><body name="astray" pos="0.04 0 0"/>',
        '<body name="top" pos="-0.02 0 0.05"/>',
    )
    close_chain(spec, Closure(kind="four-bar", bodies=BODIES, **pin), "card")
    model = spec.compile()
    assert model.eq_data[0, :6] == pytest.approx([*PIN, -0.02, 0.0, 0.05], abs=1e-15)


@pytest.mark.parametrize(
    ("closure", "words"),
    [
        ({"bodies": ("rocker", "crank", "rod")}, "names a link 'rod'; there are crank, coupler"),
        ({"kind": "six-bar"}, "kind 'six-bar' with 3 links is not known"),
        ({"pin_on_first": (-0.02, 0.0, 0.051)}, "are 1 mm apart; at most 0.1 mm"),
        ({"bodies": ("crank", "coupler")}, "has the joints coupler, not those of a four-bar"),
        ({"pin": (0.08, 0.0)}, "a pin has three coordinates, not 2"),
        ({"pin": ()}, "neither a site nor a fixed frame says where 'coupler' and 'rocker' meet"),
    ],
)
def test_a_closure_that_cannot_be_is_refused(closure: dict[str, Any], words: str) -> None:
    given = {"kind": "four-bar", "bodies": BODIES, "pin": PIN} | closure
    with pytest.raises(RobotError, match=words) as caught:
        close_chain(tree(), Closure(**given), "robots/x/card.toml")
    assert caught.value.where == "robots/x/card.toml"


def test_frames_that_do_not_meet_are_refused() -> None:
    spec = tree('<body name="tip" pos="0.08 0 0.02"/>', '<body name="top" pos="-0.02 0 0.0506"/>')
    with pytest.raises(RobotError, match=r"are 0\.6 mm apart"):
        close_chain(spec, Closure(kind="four-bar", bodies=BODIES), "card")


def test_a_chain_out_of_its_plane_is_refused_unless_its_pin_is_a_ball() -> None:
    spec = tree(axis="0 -1 0.1")
    with pytest.raises(RobotError, match="not planar: the joint 'rocker' is not a hinge parallel"):
        close_chain(spec, Closure(kind="planar", bodies=BODIES, pin=PIN), "card")
    close_chain(spec, Closure(kind="ball", bodies=BODIES, pin=PIN), "card")
    assert spec.compile().neq == 1
