"""What every member of the family of effects must honour."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import mujoco
import numpy as np
import pytest
from mujoco.batch import MODEL_FIELDS

from morph.arrays import Array
from morph.body.load import load
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.errors import EffectError
from morph.model.episodes import episode, step_for
from morph.model.fit import fit, measure
from morph.model.hypothesis import Hypothesis
from morph.model.segments import cut
from morph.model.shooting import predict
from morph.physics import EFFECTS, effect_class
from morph.physics.body_motion import body_motions
from morph.physics.effect import Effect, Parameter
from morph.physics.fluid.linear_drag import LinearDrag
from morph.physics.joint.armature import Armature
from morph.physics.motion import Motion
from morph.physics.store import effects_text, load_effects
from morph.physics.world.ground import Ground
from morph.record.recording import Channel, Recording
from morph.sim.drive import received, unsensed
from morph.sim.simulator import Simulator, compiled

SPECIFIED = Path(__file__).parents[3] / "docs" / "effects.md"


@dataclass(frozen=True, kw_only=True)
class Rig:
    """A body of the shelf, and a motion of it."""

    robot: str
    start: Mapping[str, float] = field(default_factory=dict)
    command: Mapping[str, float] = field(default_factory=dict)
    """By which part of `drive` each actuator is driven."""
    beside: tuple[Effect, ...] = ()
    """Effects without which that in question could not act."""


ARM = Rig(
    robot="double_pendulum",
    start={"shoulder": 0.4, "elbow": -0.3},
    command={"shoulder": 1.0, "elbow": 0.5},
)
SWIMMER = Rig(
    robot="swimmer_three_links", start={"front": 0.3}, command={"front": 1.5, "rear": 1.0}
)
"""It moves in a plane, where a link shows what acts along x and y and about z."""
HOPPER = Rig(
    robot="hopper",
    start={"up": 0.03, "hip": 0.3, "knee": -0.5, "pitch": 0.1},
    command={"hip": 30.0, "knee": 20.0},
    beside=(Ground(),),
)
GEARED = replace(ARM, beside=(Armature(joint="elbow", J=0.02),))
"""What lies between a motor and its link shows by the inertia of the rotor."""
STREAM = replace(SWIMMER, beside=(LinearDrag(body="head", y=2.0),))


@dataclass(frozen=True, kw_only=True)
class Felt:
    """Where, and with which parameters, an effect is felt."""

    values: Mapping[str, float]
    rig: Rig = ARM
    place: int = -1
    """Which of its places on that robot; the last one shows a mix-up of parts."""


FELT: Mapping[str, Felt] = {
    "viscous_friction": Felt(values={"b": 0.05}),
    "coulomb_friction": Felt(values={"c": 0.06}),
    "stribeck_friction": Felt(values={"c": 0.04, "s": 0.12, "vs": 0.5}),
    "load_dependent_friction": Felt(values={"c0": 0.04, "k": 0.2}),
    "position_dependent_friction": Felt(values={"c": 0.06, "a": 0.04, "n": 3.0, "phase": 0.5}),
    "quadratic_damping": Felt(values={"b2": 0.02}),
    "joint_stiffness": Felt(values={"k": 0.8, "q0": 0.3}),
    "cogging": Felt(values={"a": 0.15, "n": 6.0, "phase": 0.7}),
    "hysteresis": Felt(values={"c": 0.12, "z": 0.05}),
    "backlash": Felt(rig=GEARED, values={"gap": 0.05}),
    "series_elasticity": Felt(rig=GEARED, values={"k": 6.0, "d": 0.02}),
    "end_stop": Felt(values={"q_stop": -0.2, "k": 40.0, "d": 0.3}),
    "armature": Felt(values={"J": 0.01}),
    "actuator_delay": Felt(values={"T": 0.02}),
    "actuator_lag": Felt(values={"T": 0.03}),
    "torque_scale": Felt(values={"gain": 1.3}),
    "torque_saturation": Felt(values={"limit": 0.15}),
    "speed_torque_limit": Felt(values={"tau0": 0.3, "v0": 2.0}),
    "back_emf": Felt(values={"k": 0.1}),
    "thermal_derating": Felt(values={"floor": 0.3, "rate": 5.0, "level": 0.3}),
    "voltage_sag": Felt(values={"k": 0.8}),
    "dead_zone": Felt(values={"threshold": 0.1}),
    "sensor_bias": Felt(values={"bias": 0.05}),
    "sensor_scale": Felt(values={"gain": 1.1}),
    "timestamp_offset": Felt(values={"T": 0.02}),
    "link_inertia": Felt(values={"mass": 0.6, "inertia": 1.8}),
    "com_offset": Felt(values={"x": 0.03, "z": 0.05}),
    "payload": Felt(values={"m": 0.3, "x": 0.05, "z": -0.28}),
    "external_push": Felt(values={"start": 0.1, "end": 0.2, "x": 0.08, "z": 0.05}),
    "tether": Felt(values={"k": 5.0, "length": 0.2, "x": 0.5, "z": -0.5, "cz": -0.1}),
    "base_tilt": Felt(values={"roll": 0.05, "pitch": 0.1}),
    "added_mass": Felt(values={"x": 0.4, "ry": 0.01, "cz": -0.05}),
    "buoyancy": Felt(values={"volume": 2e-4, "cz": -0.2}),
    "linear_drag": Felt(values={"x": 0.8, "ry": 0.03, "cz": -0.05}),
    "quadratic_drag": Felt(values={"x": 0.8, "ry": 0.01, "cz": -0.05}),
    "thrust": Felt(values={"C": 0.5, "span": 0.1, "z": -0.2, "nx": 1.0}),
    "fluid_current": Felt(rig=STREAM, values={"x": 0.2, "y": 0.5}),
    "ground": Felt(rig=replace(HOPPER, beside=()), values={"height": 0.0}),
    "ground_slope": Felt(rig=HOPPER, values={"pitch": 0.2}),
    "contact_friction": Felt(rig=HOPPER, values={"mu": 0.05}, place=0),
    "contact_softness": Felt(rig=HOPPER, values={"stiffness": 3e3, "damping": 50.0}, place=4),
    "restitution": Felt(rig=HOPPER, values={"e": 0.8}, place=4),
}
"""Parameters at which each effect is felt."""

every_effect = pytest.mark.parametrize("kind", EFFECTS, ids=lambda kind: kind.name)
linear = pytest.mark.parametrize(
    "kind",
    [kind for kind in EFFECTS if kind.strengths and kind.suspected],
    ids=lambda kind: kind.name,
)
"""Those that a diagnosis looks for; others meet their regressors in `test_regressors.py`."""
every_parameter = pytest.mark.parametrize(
    ("kind", "known"),
    [
        pytest.param(kind, known, id=f"{kind.name}-{known.name}")
        for kind in EFFECTS
        for known in kind.parameters()
    ],
)


@pytest.fixture(scope="module")
def robot() -> Robot:
    return load("double_pendulum")


def felt(kind: type[Effect], robot: Robot) -> Effect:
    """Return the effect as it is felt on its own rig."""
    told = FELT[kind.name]
    return replace(kind.at(kind.places(robot)[told.place]), **told.values)


def rig_of(kind: type[Effect]) -> tuple[Rig, Robot]:
    rig = FELT[kind.name].rig
    return rig, load(rig.robot)


def drive(times: Array) -> Array:
    """Return a command, N m, with slow and fast parts and sudden steps."""
    steps = 0.35 * np.sign(np.sin(2.0 * np.pi * 0.45 * times))
    return np.asarray(steps + 0.3 * np.sin(2.0 * np.pi * 1.1 * times))


def run(rig: Rig, effects: tuple[Effect, ...], *, step: float, seconds: float) -> Recording:
    def driven(actuator: str, after: float) -> Callable[[Array], Array]:
        return lambda times: rig.command[actuator] * drive(times + after)

    return Simulator(load(rig.robot), effects=(*rig.beside, *effects), step=step).run(
        seconds=seconds,
        start=rig.start,
        command={name: driven(name, 0.7 * at) for at, name in enumerate(rig.command)},
    )


def test_every_effect_has_an_example_here() -> None:
    assert [kind.name for kind in EFFECTS] == list(FELT)


@every_effect
def test_an_effect_says_what_it_is(kind: type[Effect], robot: Robot) -> None:
    assert kind.kind in {"joint", "actuator", "sensor", "body", "contact", "world"}
    assert kind.twins
    assert kind.name not in kind.twins
    assert kind.excited_by.endswith(".")
    assert set(kind.strengths) <= {known.name for known in kind.parameters()}
    assert effect_class(kind.name) is kind
    # Names that rivals are told by must exist, at the latest in the vocabulary's file.
    text = SPECIFIED.read_text()
    for name in (kind.name, *kind.twins, *kind.separate_by, *filter(None, [kind.simpler])):
        assert name in text


@every_effect
def test_an_effect_has_places_on_a_robot_and_names_its_own(
    kind: type[Effect], robot: Robot
) -> None:
    for where in kind.places(robot):
        effect = kind.at(where)
        assert effect.where == where
        assert effect.label == f"{kind.name}@{where}"
        assert where in effect.statement()
        assert effect.statement().endswith(".")


@every_parameter
def test_a_parameter_has_a_unit_and_its_default_lies_in_its_bounds(
    kind: type[Effect], known: Parameter, robot: Robot
) -> None:
    assert known.unit
    assert known.low < known.high
    for value in (known.default, known.neutral, *known.scan):
        assert value is None or known.low <= value <= known.high
    assert getattr(kind.at(kind.places(robot)[0]), known.name) == known.default


def coupling(known: Parameter) -> bool:
    """Return whether it couples two axes of a tensor, and alone would make it indefinite."""
    return "_" in known.name


@every_parameter
def test_a_value_out_of_bounds_is_refused_with_the_bounds(
    kind: type[Effect], known: Parameter, robot: Robot
) -> None:
    effect = kind.at(kind.places(robot)[0])
    width = known.high - known.low
    for value in (known.low - 0.01 * width, known.high + 0.01 * width, np.nan, np.inf, -np.inf):
        with pytest.raises(EffectError) as caught:
            replace(effect, **{known.name: value})
        assert f"{known.name} = " in caught.value.what
        assert f"outside {known.low:g} to {known.high:g}" in caught.value.what
        assert caught.value.where == f"effect {effect.label}"
        assert known.name in caught.value.fix
    if coupling(known):
        return
    for value in (known.low, known.high):
        assert getattr(replace(effect, **{known.name: value}), known.name) == value


@pytest.mark.parametrize(
    "kind", [kind for kind in EFFECTS if kind.kind != "contact"], ids=lambda kind: kind.name
)
def test_models_of_all_strengths_have_the_same_sizes(kind: type[Effect]) -> None:
    # One batch simulates them side by side.
    rig, robot = rig_of(kind)
    effect = felt(kind, robot)
    one, other = (
        Simulator(robot, effects=(*rig.beside, each)).model for each in (effect, effect.neutral())
    )
    for name in MODEL_FIELDS:
        path = name.split(".")
        sizes = {np.shape(functools.reduce(getattr, path, model)) for model in (one, other)}
        assert len(sizes) == 1, name


@every_effect
def test_a_neutral_effect_leaves_a_simulation_unchanged(kind: type[Effect]) -> None:
    # A neutral effect writes zeros or ones. One that acts before every step runs by
    # another path of MuJoCo: whatever it may round differently, 250 steps of a motion that
    # parts at about 10 / s make of 1e-16 no more than 1e-16 exp(5) = 1.5e-14.
    rig, robot = rig_of(kind)
    plain = run(rig, (), step=0.002, seconds=0.5)
    neutral = run(rig, (felt(kind, robot).neutral(),), step=0.002, seconds=0.5)
    assert plain.channels.keys() == neutral.channels.keys()
    for name in plain.channels:
        assert np.abs(plain[name] - neutral[name]).max() < (1e-12 if kind.suspected else 1e-300)


@every_effect
def test_an_effect_that_is_felt_changes_what_is_measured(kind: type[Effect]) -> None:
    # Without this the test above could pass for an effect that never acts. An encoder
    # of 4096 counts resolves 1.5 mrad: what is felt here moves at least six of them.
    rig, robot = rig_of(kind)
    plain = run(rig, (), step=0.002, seconds=0.5)
    changed = run(rig, (felt(kind, robot),), step=0.002, seconds=0.5)
    seen = {n: changed.channel(n).at(c.time) for n, c in plain.channels.items()}
    assert max(np.abs(plain[n] - seen[n]).max() for n in plain.channels) > 0.01


# The chord of a paddle on a fixed hinge passes through it: there thrust takes nothing. What it
# takes of a free paddle, and a powered motor of its joint, is tested with their own laws.
@pytest.mark.parametrize(
    "kind",
    [k for k in EFFECTS if k.dissipative and k.name not in {"thrust", "back_emf"}],
    ids=lambda kind: kind.name,
)
def test_a_dissipative_effect_never_adds_energy(kind: type[Effect]) -> None:
    # MuJoCo's step is a leapfrog, velocities half a step behind positions. With velocities
    # averaged onto positions it conserves, in place of E, E + h^2 (v^2 V'' / 12 - V'^2 / 24 I)
    # (Hairer, Lubich and Wanner 2006, IX.3, eq. 3.4). Here V' = V'' = 4.905 N m at most,
    # I = 0.251 kg m2, v = sqrt(2 * 4.905 (1 - cos 2.5) / I) = 8.4 rad/s, h = 2 ms, so E ripples
    # by 4e-6 (28.8 + 4.0) = 1.3e-4 J, of 8.8 J. Up from a low and on to a high is twice that.
    pendulum, step, ripple = load("pendulum"), 0.002, 1.3e-4
    told = FELT[kind.name]
    effect = replace(kind.at(kind.places(pendulum)[-1]), **told.values)

    def energy(effects: tuple[Effect, ...]) -> Array:
        # In a fluid the choice would be rk4, which is no leapfrog.
        simulator = Simulator(pendulum, effects=effects, step=step, integrator="implicitfast")
        out = simulator.run(seconds=4.0, start={"hinge": 2.5})
        position, velocity = out["hinge.position"][:-1], out["hinge.velocity"]
        speed = 0.5 * (velocity[1:] + velocity[:-1])
        return np.asarray(0.5 * 0.251 * speed**2 - 4.905 * np.cos(position))

    without, under = energy(()), energy((effect,))
    assert np.ptp(without) < 2.0 * ripple
    assert (under - np.minimum.accumulate(under)).max() < 2.0 * ripple
    assert (under - without).max() < 2.0 * ripple
    # The least any of them takes in 4 s and about 20 rad: 0.04 N m * 20 rad = 0.8 J.
    assert under[-1] < without[-1] - 0.5


class Still:
    """States, one a row, as an effect that acts before every step sees them."""

    step = 0.002

    def __init__(self, motion: Motion) -> None:
        self._motion, self.applied = motion, np.zeros_like(motion.velocity)

    def position(self, joint: str) -> Array:
        return np.asarray(self._motion.position[:, self._motion.joints[joint]])

    def velocity(self, joint: str) -> Array:
        return self._motion.speed(joint)

    def force(self, joint: str) -> Array:
        return np.asarray(self.applied[:, self._motion.joints[joint]])


def missing(
    robot: Robot, effects: tuple[Effect, ...], reading: Array, v: Array, a: Array, command: Array
) -> Array:
    """Return the force that a motion needs beyond what a model gives it, (samples, dofs)."""
    model = compiled(spec_of(robot), effects, robot).model
    data, need = mujoco.MjData(model), np.empty_like(v)
    names = [joint.name for joint in robot.joints]
    position = np.stack(
        [unsensed(effects, f"{n}.position", reading[:, i]) for i, n in enumerate(names)], axis=1
    )
    told = np.stack(
        [received(effects, x.name, command[:, i], 0.002) for i, x in enumerate(robot.actuators)],
        axis=1,
    )
    for k in range(len(v)):
        data.qpos[:], data.qvel[:], data.qacc[:], data.ctrl[:] = position[k], v[k], a[k], told[k]
        mujoco.mj_inverse(model, data)
        mujoco.mj_fwdActuation(model, data)
        need[k] = data.qfrc_inverse - data.qfrc_actuator
    return need


def moments(model: mujoco.MjModel) -> Array:
    """Return the joint forces of actuators told one, (actuators, dofs): each turns one joint."""
    moment = np.zeros((model.nu, model.nv))
    for index in range(model.nu):
        moment[index, model.jnt_dofadr[model.actuator_trnid[index, 0]]] = 1.0
    return moment


@linear
def test_a_regressor_tells_the_force_that_the_simulation_feels(kind: type[Effect]) -> None:
    _, robot = rig_of(kind)
    effect = felt(kind, robot)
    if kind.kind == "sensor":
        # First order only: an offset e misses e^2 / 2 times a curvature of at most 5 N m,
        # 2.5e-10 N m for 1e-5 rad.
        effect = replace(effect, **dict.fromkeys(kind.strengths, 1e-05))
    if kind.name == "com_offset":
        # First order only: an offset d misses m d^2 times an angular acceleration of at most
        # 2 + 2 rad/s2, and half as much by centrifugal forces: 0.64 * 1e-10 * 6 = 4e-10 N m.
        effect = replace(effect, x=1e-05, z=1e-05)
    rng = np.random.default_rng(0)
    samples, dofs = 400, len(robot.joints)
    model = compiled(spec_of(robot), (), robot).model
    q, a = rng.uniform(-1.0, 1.0, (2, samples, dofs))
    # No slower than 0.5 rad/s: near rest dry friction is whatever holds, not a law of speed.
    # It acts against the way that the joint has gone since the sample before.
    way = np.sign(np.diff(q, axis=0, prepend=0.0))
    v = way * rng.uniform(0.5, 2.0, (samples, dofs))
    # A ramp: there a delay or a lag by T costs exactly T times the rate, once settled.
    rate, time = np.array([0.7, -0.4]), 0.002 * np.arange(samples)
    command = time[:, None] * rate

    def need(effects: tuple[Effect, ...], reading: Array) -> Array:
        return missing(robot, effects, reading, v, a, command)

    stiffness = np.empty((samples, dofs, dofs))
    for dof in range(dofs):
        shift = 1e-5 * np.eye(dofs)[dof]
        stiffness[:, :, dof] = (need((), q + shift) - need((), q - shift)) / 2e-5
    drives = moments(model)
    bodies = [effect.where] if kind.kind == "body" else []
    motion = Motion(
        time=time,
        position=q,
        velocity=v,
        acceleration=a,
        drive=command[:, :, None] * drives,
        drive_rate=np.broadcast_to(rate[:, None] * drives, (samples, *drives.shape)),
        stiffness=stiffness,
        joints={joint.name: index for index, joint in enumerate(robot.joints)},
        actuators={actuator.name: index for index, actuator in enumerate(robot.actuators)},
        driven={actuator.name: actuator.joint for actuator in robot.actuators},
        bodies=body_motions(model, bodies, q, v, a),
    )
    still = Still(motion)
    effect.before_step(still, effect.initial_state(still))
    explained = need((), q) - need((effect,), q) + still.applied
    told = effect.regressor(motion) @ effect.coefficients
    # A lag of 30 ms settles within 0.7 s to exp(-0.7 / 0.03) = 7e-11 of 0.8 N m.
    # The first sample has none before it.
    settled = slice(350 if kind.kind == "actuator" else 1, None)
    assert told.shape == (samples, dofs)
    assert np.abs(told[settled]).max() > 1e-6
    assert np.abs(told - explained)[settled].max() < 1e-9


@linear
def test_its_parameters_are_recovered_from_a_simulation_with_it(kind: type[Effect]) -> None:
    # Simulated at 0.5 ms and read every 5 ms without noise. Two errors remain, both known.
    # The fit steps at 2.5 ms or 5 ms: (w h)^2 / 24 of the forces at w = 10 rad/s, 1e-4.
    # The simulator holds a command over the step after it, the fit centres it: half a
    # step of 0.5 ms is 1.3 % of a delay of 20 ms. 3 % bounds both, with their leverage.
    # A shape read off the speed before each step is read half a step late: at 40 rad/s2,
    # 40 * 0.00125 = 0.05 rad/s of the 0.5 rad/s that fade Stribeck's friction, 10 %.
    rig, robot = rig_of(kind)
    true = felt(kind, robot)
    fine = run(rig, (true,), step=0.0005, seconds=4.0)
    channels = {
        name: c if c.hold else Channel(time=c.time[::10], value=c.value[::10])
        for name, c in fine.channels.items()
    }
    recording = replace(fine, channels=channels)
    step = step_for([recording], robot)
    # Half of everything that differs from neutral; half of a shape.
    wrong = {
        known.name: (known.neutral or 0.0)
        + 0.5 * (getattr(true, known.name) - (known.neutral or 0.0))
        for known in kind.parameters()
        if known.free
    }
    guess = Hypothesis(robot=robot, step=step, knobs=(), effects=(replace(true, **wrong),))
    segments = cut([episode(recording, robot, step)], 1.0)
    point, start = guess.start, segments.start
    for _ in range(2):
        # Again with errors in units of what is left: the first unit is the wrong guess's.
        read = predict(guess, segments, [point], [start])[0]
        scale, weight = measure(segments, read)
        found = fit(guess, segments, scale, weight, point=point, start=start, iterations=8)
        point, start = found.point, found.start
    (effect,) = found.hypothesis.effects
    fixed = {known.name for known in kind.parameters() if not known.free}
    for name, value in FELT[kind.name].values.items():
        if name in fixed:
            continue
        # Two axes of one link pull on it almost alike: 1 % of both is up to 6 % of one.
        percent = 3 if name in kind.strengths and kind.kind != "body" else 10
        assert getattr(effect, name) == pytest.approx(value, rel=0.01 * percent), effect


@every_effect
def test_an_effect_survives_being_written_and_read(
    kind: type[Effect], robot: Robot, tmp_path: Path
) -> None:
    rng = np.random.default_rng(0)
    places = kind.places(robot)
    effects = tuple(
        replace(
            kind.at(place),
            **{
                k.name: float(rng.uniform(k.low, k.high)) * (1e-3 if coupling(k) else 1.0)
                for k in kind.parameters()
            },
        )
        for place in (*places, 'a "b" \\c')[: 1 if kind.kind == "world" else None]
    )
    path = tmp_path / "effects.toml"
    path.write_text(effects_text(effects))
    assert load_effects(path) == effects
