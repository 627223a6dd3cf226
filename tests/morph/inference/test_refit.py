"""Own parameters and effects refitted to a pendulum that SciPy integrates."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from morph.arrays import Array
from morph.body.load import load
from morph.body.robot import Robot
from morph.inference.columns import Columns, acting
from morph.inference.dictionary import RARE, search_beside
from morph.inference.observed import observed
from morph.inference.quadratic import LogPosterior, information, offset, quadratic
from morph.inference.refit import refitted, seen
from morph.inference.validate import Validation
from morph.model.deadline import Deadline
from morph.model.episodes import Episode, episode
from morph.model.hypothesis import Hypothesis
from morph.model.nuisance_parameters import knobs
from morph.physics import EFFECTS
from morph.physics.effect import Effect
from morph.record.recording import Channel, Recording

STEP, READ, NOISE = 0.004, 0.008, 1e-3
MASS, ARM, INERTIA = 2.0, 0.5, 0.02
PENDULUM = f"""
<mujoco model="pendulum"><worldbody><body name="rod"><joint name="hinge" axis="0 1 0"/>
  <inertial pos="0 0 {-ARM}" mass="{MASS}" diaginertia="{INERTIA} {INERTIA} {INERTIA}"/>
</body></worldbody><actuator><motor name="motor" joint="hinge"/></actuator></mujoco>
"""
HEAVIER, VISCOUS, COULOMB, BIAS = 1.1, 0.3, 0.4, 0.05
KINDS = {kind.__name__: kind for kind in EFFECTS}


def effect(kind: str, where: str, **figures: float) -> Effect:
    """Return an effect of a kind, with some figures of its own."""
    return replace(KINDS[kind].at(where), **figures)  # type: ignore[type-var]


@pytest.fixture(scope="module")
def pendulum(tmp_path_factory: pytest.TempPathFactory) -> Robot:
    """The pendulum as described."""
    path = tmp_path_factory.mktemp("robot") / "pendulum.xml"
    path.write_text(PENDULUM)
    return load(str(path))


@pytest.fixture(scope="module")
def run(pendulum: Robot) -> Episode:
    """Six seconds of a heavier one with friction and a biased sensor, torque held for 4 ms each."""
    time = np.arange(0.0, 6.0, STEP)
    torque = 4.0 * np.sin(2.1 * time) + 3.0 * np.sin(5.3 * time)
    inertia = HEAVIER * MASS * ARM**2 + INERTIA

    def rates(t: float, state: np.ndarray) -> list[float]:
        q, v = state
        drive = torque[min(int(t / STEP + 1e-9), len(time) - 1)]
        lost = VISCOUS * v + COULOMB * np.tanh(v / 1e-3)
        return [v, (drive - lost - HEAVIER * MASS * ARM * 9.81 * np.sin(q)) / inertia]

    found = solve_ivp(
        rates, (0.0, time[-1]), [0.4, 0.0], t_eval=time, method="LSODA", rtol=1e-8, atol=1e-10,
        max_step=STEP,
    )  # fmt: skip
    every = round(READ / STEP)
    read = found.y[0, ::every] + BIAS
    read = read + NOISE * np.random.default_rng(0).normal(size=len(read))
    recording = Recording(
        name="swing",
        channels={
            "hinge.position": Channel(time=time[::every], value=read),
            "motor.command": Channel(time=time, value=torque, hold=True),
        },
    )
    return episode(recording, pendulum, STEP)


@pytest.fixture(scope="module")
def nominal(pendulum: Robot) -> Hypothesis:
    """The description, whose mass and centre may be wrong."""
    vary = {"mass": 0.25, "com": 0.0, "inertia": 0.0, "gain": 0.0}
    return Hypothesis(robot=pendulum, step=STEP, knobs=knobs(pendulum, vary))


MISSING = (
    effect("ViscousFriction", "hinge"),
    effect("CoulombFriction", "hinge"),
    effect("SensorBias", "hinge.position"),
)


def test_the_true_figures_are_recovered(nominal: Hypothesis, run: Episode) -> None:
    whole = replace(nominal, effects=MISSING)
    found = refitted(whole, whole.start, [run], rounds=4)
    assert nominal.names == ("mass:rod",)
    lighter, viscous, coulomb, bias = found.point
    # Of 750 readings: the bias is known to 1e-3 / sqrt(750); forces near 5 N m move the pendulum
    # by a radian, so 1e-3 rad tells 5e-3 N m in any second. A grid of 4 ms costs as much.
    assert np.exp(lighter) == pytest.approx(HEAVIER, abs=5e-3)
    assert viscous == pytest.approx(VISCOUS, abs=0.03)
    assert coulomb == pytest.approx(COULOMB, abs=0.04)
    assert bias == pytest.approx(BIAS, abs=3e-3)


def test_each_missing_effect_costs_evidence(nominal: Hypothesis, run: Episode) -> None:
    def evidence(effects: tuple[Effect, ...]) -> float:
        hypothesis = replace(nominal, effects=effects)
        return refitted(hypothesis, hypothesis.start, [run], rounds=3).evidence

    whole = evidence(MISSING)
    for gone in MISSING:
        assert evidence(tuple(each for each in MISSING if each is not gone)) < whole - 5.0
    # A fourth effect, which nothing calls for, gains less than its price in a search: 3 nats, and
    # the logarithm of some sixty places.
    assert evidence((*MISSING, effect("Armature", "hinge"))) < whole + 7.0


def test_a_refit_from_its_own_end_stays_there(nominal: Hypothesis, run: Episode) -> None:
    whole = replace(nominal, effects=MISSING)
    first = refitted(whole, whole.start, [run], rounds=4)
    again = refitted(whole, first.point, [run], origin=first, rounds=3)
    assert again.evidence >= first.evidence - 1e-6


def test_a_first_point_worse_than_the_origin_is_moved_toward_it(
    nominal: Hypothesis, run: Episode
) -> None:
    none = refitted(nominal, nominal.start, [run], rounds=3)
    biased = replace(nominal, effects=(effect("SensorBias", "hinge.position"),))
    far = np.append(none.point, 3.0)
    # Without a step the evidence is that of the first point: of 3 rad, and of 0.9 or 0.3.
    alone = refitted(biased, far, [run], rounds=0).evidence
    assert refitted(biased, far, [run], origin=none, rounds=0).evidence > alone + 100.0


def test_a_step_that_is_too_long_is_shortened(
    nominal: Hypothesis, run: Episode, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = replace(nominal, effects=MISSING)
    start = refitted(whole, whole.start, [run], rounds=0).evidence
    newton = LogPosterior.step

    def tenfold(at: LogPosterior, damping: float = 0.0) -> tuple[Array, int, float]:
        step, rank, gained = newton(at, damping=damping)
        return 10.0 * step, rank, gained

    monkeypatch.setattr(LogPosterior, "step", tenfold)
    # A tenth of it is the Gauss-Newton step. The figures start at least five standard deviations
    # off, of which each is worth 12 nats.
    assert refitted(whole, whole.start, [run], rounds=1).evidence > start + 12.0


def test_a_damped_step_is_tried_where_the_whole_one_leads_away(
    nominal: Hypothesis, run: Episode, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = replace(nominal, effects=MISSING)
    start = refitted(whole, whole.start, [run], rounds=0).evidence
    newton = LogPosterior.step

    def astray(at: LogPosterior, damping: float = 0.0) -> tuple[Array, int, float]:
        step, rank, gained = newton(at, damping=damping)
        return step if damping > 0.0 else -step, rank, gained

    monkeypatch.setattr(LogPosterior, "step", astray)
    # As above: figures that start five standard deviations off are worth 12 nats each.
    assert refitted(whole, whole.start, [run], rounds=1).evidence > start + 12.0


def test_the_model_includes_smooth_effects_only(nominal: Hypothesis) -> None:
    effects = (
        effect("ViscousFriction", "hinge", b=0.7),
        effect("CoulombFriction", "hinge", c=0.4),
        effect("DeadZone", "motor", threshold=0.1),
        effect("SensorBias", "hinge.position", bias=0.1),
        effect("Payload", "rod", m=0.5),
    )
    whole = replace(nominal, effects=effects)
    model, beside = acting(whole, whole.start)
    assert [each.name for each in beside] == ["coulomb_friction", "dead_zone", "sensor_bias"]
    assert model.dof_damping[0] == pytest.approx(0.7)
    assert model.dof_frictionloss[0] == 0.0
    assert model.body_mass[-1] == pytest.approx(MASS + 0.5)


def test_columns_are_derivatives_of_the_pendulum(nominal: Hypothesis, run: Episode) -> None:
    effects = (
        effect("ViscousFriction", "hinge", b=0.3),
        effect("CoulombFriction", "hinge", c=0.4),
        effect("Payload", "rod", m=0.2),
        effect("SensorBias", "hinge.position", bias=0.05),
    )
    whole = replace(nominal, effects=effects)
    (here,) = seen(whole, whole.start, [run], seen(nominal, nominal.start, [run]))
    moved, shown = Columns.of(whole, whole.start).along(here)
    assert moved[:, :, 0] == pytest.approx(-here.about.acceleration)
    velocity, position = here.motion.velocity[:, 0], here.motion.position[:, 0]
    # The payload is at the link's origin, on the axis: it has neither inertia nor weight there.
    inertia = MASS * ARM**2 + INERTIA
    own = -MASS * ARM**2 * here.motion.acceleration[:, 0] - MASS * ARM * 9.81 * np.sin(position)
    # The trapezoidal rule adds half a step of the friction, 0.3 N m s/rad, to the inertia.
    scale = 1.0 / (inertia + 0.5 * STEP * 0.3)
    names = {name: 1 + at for at, name in enumerate(whole.names)}
    exact = {
        "mass:rod": own * scale,
        "viscous_friction@hinge:b": -velocity * scale,
        "coulomb_friction@hinge:c": -np.sign(velocity) * scale,
        "payload@rod:m": 0.0 * velocity,
        "sensor_bias@hinge.position:bias": 0.0 * velocity,
    }
    moving = np.abs(velocity) > 0.2
    for name, accelerates in exact.items():
        # A step of 1e-3 in the logarithm of the mass: a one-sided difference is off by half of it.
        assert moved[moving, 0, names[name]] == pytest.approx(
            accelerates[moving], rel=2e-3, abs=1e-6
        ), name
    bias = shown[:, 0, names["sensor_bias@hinge.position:bias"]]
    assert bias == pytest.approx(np.ones(len(bias)))


def test_the_prior_is_about_the_nominal(nominal: Hypothesis) -> None:
    whole = replace(nominal, effects=MISSING)
    point = whole.start + 0.1
    assert information(whole).tolist() == pytest.approx([1.0 / 0.25**2, 0.0, 0.0, 0.0])
    assert offset(whole, point).tolist() == pytest.approx([0.1, 0.0, 0.0, 0.0])


def test_effects_act_on_the_motion_that_is_seen(nominal: Hypothesis, run: Episode) -> None:
    model, beside = acting(nominal, nominal.start)
    plain = observed(model, nominal.robot, run, effects=beside)
    biased = effect("SensorBias", "hinge.position", bias=BIAS)
    shifted = observed(model, nominal.robot, run, effects=[biased], before=plain)
    # The sensor reads that much more than the joint has turned.
    off = plain.motion.position - shifted.motion.position
    assert np.median(off) == pytest.approx(BIAS, abs=0.3 * BIAS)


def test_the_likeliest_point_without_an_effect_leaves_it_at_neutral(
    nominal: Hypothesis, run: Episode
) -> None:
    whole = replace(nominal, effects=MISSING)
    found = refitted(whole, whole.start, [run], rounds=2)
    about = quadratic(whole, found.point, found.runs)
    idle = about.idle([0, 2])
    # Mass, viscous friction, Coulomb friction, bias.
    assert idle[2] == 0.0
    assert (np.abs(idle - found.point) > 1e-4).tolist() == [True, True, True, True]
    fewer, point = about.reduced([0, 2])
    assert [each.name for each in fewer.effects] == ["viscous_friction", "sensor_bias"]
    assert point.tolist() == pytest.approx(idle[[0, 1, 3]].tolist())


def test_laws_of_sensors_are_looked_for_by_their_readings(
    nominal: Hypothesis, run: Episode
) -> None:
    rubbing = replace(nominal, effects=MISSING[:2])
    base = refitted(rubbing, rubbing.start, [run], rounds=2)
    none = refitted(nominal, nominal.start, [run], rounds=1)
    paddle = effect("Thrust", "rod", span=0.1, z=-0.5, nx=1.0)
    prior, wet = (search_beside(none, known, None, 4).prior for known in ((), (paddle,)))
    # A cable of nine shapes is as rare as drag in air.
    tied = prior.alone["tether@rod"] - prior.alone["coulomb_friction@hinge"]
    assert tied == pytest.approx(RARE + np.log(9.0))
    for alone, price in ((prior.alone, RARE), (wet.alone, 0.0)):
        # Drag is looked for at three points; nobody says that a robot without a paddle is wet.
        more = alone["linear_drag@rod"] - alone["coulomb_friction@hinge"]
        assert more == pytest.approx(price + np.log(3.0))
    sets = search_beside(base, (), prior, 4).sets(1)
    # A centre of mass beside the rod moves the rest alike.
    found = {each.effects[0].label: each for each in sets if each.effects}
    biased = found["sensor_bias@hinge.position"]
    assert biased.gain > 20.0
    assert biased.effects[0].bias == pytest.approx(BIAS, abs=0.01)  # type: ignore[attr-defined]


def test_without_an_elastic_drive_its_motor_turns_with_the_joint(
    nominal: Hypothesis, run: Episode
) -> None:
    # A rotor of its own can be given no spring that is stiff enough: it is taken out instead.
    effects = (effect("SeriesElasticity", "hinge", k=50.0, d=0.5), MISSING[0])
    whole = replace(nominal, effects=effects)
    runs = seen(whole, whole.start, [run], seen(nominal, nominal.start, [run]))
    validation = Validation.of([run])
    about = quadratic(whole, whole.start, runs, blocks=validation.blocks)
    (alone,) = validation.losses_of(about, runs, [[1]])
    rubbing = replace(nominal, effects=MISSING[:1])
    points = [about.without_fold(k).idle([1])[[0, -1]] for k in range(4)]
    assert alone == pytest.approx(validation.losses(rubbing, [points], runs)[0])
    # A refit brings the spring near to none: as it stands it shows.
    soft = validation.losses(whole, [[whole.start] * 4], runs)[0]
    assert np.abs(soft - alone).max() > 0.1


def test_no_step_begins_after_the_deadline(nominal: Hypothesis, run: Episode) -> None:
    found = refitted(nominal, nominal.start, [run], deadline=Deadline(time=-1.0))
    assert found.point.tolist() == nominal.start.tolist()
