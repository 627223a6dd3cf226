"""A case drawn from its suite, seed and number: mechanism, truth, logger and runs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from experiments.concealed.errors import BenchmarkError
from experiments.concealed.excite import Logger, draw_logger, plan
from experiments.concealed.law import Law, Setting
from experiments.concealed.mechanism import TORQUE, Mechanism
from experiments.concealed.mechanisms import FAMILIES, draw_mechanism
from experiments.concealed.plant import Plant
from experiments.concealed.refit import ratios_after_refit
from experiments.concealed.scales import Scales, scales_of
from experiments.concealed.simulate import Motion
from experiments.concealed.sizing import FINEST, NoSize, settle, size_for
from experiments.concealed.suites import LAWS, SUITES, Suite
from experiments.concealed.ties import are_distinct
from experiments.concealed.truth import Effect, Truth

SECONDS = 12.0
"""Length of each of the five runs, s."""
VARY = {"mass": (0.05, 0.1, 0.25), "com": (0.05, 0.1, 0.25), "inertia": (0.05, 0.1, 0.25),
        "gain": (0.02, 0.05, 0.1)}  # fmt: skip
"""Fractions by which the figures of descriptions may be wrong."""
SWING = float(np.sqrt(43.0 / 0.0013))
"""Rate at which the rotor of an industrial arm's drive swings on the spring of its gear, rad/s."""
FAINTEST = 0.3
"""Smallest ratio after a refit of the own parameters; with thousands of readings, still plain."""
EXCLUSIVE = (
    {"backlash", "series_elasticity"},
    {"coulomb_friction", "stribeck_friction"},
)
"""Laws of which one joint has at most one."""


@dataclass(frozen=True, kw_only=True)
class Case:
    """One case, before anything of it is written."""

    name: str
    """Name of its folder."""
    suite: str
    """Name of its suite."""
    vary: Mapping[str, float]
    """Fraction by which each kind of figure may be wrong."""
    factors: Mapping[str, tuple[float, ...]]
    """True figures over the described, by kind and link or joint."""
    logger: Logger
    """How it was logged."""
    truth: Truth
    """What is true."""
    strengths: tuple[float, ...]
    """Effect-to-noise ratio of each effect."""
    left: tuple[float, ...]
    """The same of what a refit of the description's own parameters leaves."""
    motions: tuple[Motion, ...]
    """What happened in each run."""
    rng: np.random.Generator
    """What is left of its chance, for the logs."""
    way: str = "read"
    """Of `suites.WAYS`: how it was logged where joints were."""
    hidden: int = 0
    """The joint without an encoder where one has none."""

    @property
    def mechanism(self) -> Mechanism:
        """The described mechanism."""
        return self.truth.mechanism


def draw_case(suite: str, seed: int, number: int, *, seconds: float = SECONDS) -> Case:
    """Return the case of a suite, a seed and a number; the same on every call."""
    about = SUITES[suite]
    drawn, way = divmod(number, len(about.ways))
    for attempt in range(50):
        rng = np.random.default_rng([about.number, seed, drawn, attempt])
        try:
            case = _try_case(suite, seed, drawn, rng, seconds)
        except NoSize:
            continue
        name = f"{suite}_{seed}_{number:04d}"
        hidden = int(np.random.default_rng([7, seed, drawn]).integers(len(case.mechanism.joints)))
        return replace(case, name=name, way=about.ways[way], hidden=hidden)
    raise NoSize(
        f"no case {number} of seed {seed} could be drawn", where=suite, fix="take another seed"
    )


def _try_case(suite: str, seed: int, number: int, rng: np.random.Generator, seconds: float) -> Case:
    about = SUITES[suite]
    wanted, family = _wanted(about, seed, number, rng)
    mechanism = draw_mechanism(family, rng)
    vary = {kind: float(rng.choice(choice)) for kind, choice in VARY.items()}
    base, factors = _perturb(mechanism.plant, vary, rng)
    logger = draw_logger(mechanism, rng, quiet=about.drives)
    runs = plan(mechanism, logger, rng, seconds)
    peak = np.abs(np.concatenate([run.feed for run in runs])).max(axis=0)
    most = np.where(base.of_joint("drive") == TORQUE, (1.6 * peak).round(3) + 0.001, np.inf)
    bare = mechanism.plant.with_joint(slice(None), most=most)
    mechanism = replace(mechanism, plant=bare)
    base = base.with_joint(slice(None), most=most, count=logger.count)
    truth = Truth(mechanism=mechanism, base=base, runs=runs, error=logger.error)
    calm = [truth.move(run) for run in (0, 1)]
    scales = scales_of(base, calm)
    if about.drives:
        truth = _real_drives(truth, scales, vary, rng, seconds)
    else:
        for law in wanted:
            truth = _add(truth, law, scales, vary, rng, seconds)
    if not are_distinct(truth):
        raise NoSize("two effects are twins", where=mechanism.family, fix="draw another case")
    truth, motions, strengths = settle(truth, checked=not about.drives)
    left = ratios_after_refit(truth, motions[:-1], vary)
    if about.events:
        truth, motions = _begun(truth, motions, rng)
    ticking = any(effect.law.name == "clock_drift" for effect in truth.effects)
    if left and min(left) < FAINTEST and not (ticking or about.drives):
        raise NoSize("a refit hides an effect", where=mechanism.family, fix="draw another case")
    return Case(
        name=f"{suite}_{seed}_{number:04d}", suite=suite, vary=vary, factors=factors,
        logger=logger, truth=truth, strengths=strengths, left=left, motions=motions, rng=rng,
    )  # fmt: skip


def _wanted(
    about: Suite, seed: int, number: int, rng: np.random.Generator
) -> tuple[tuple[Law, ...], str]:
    """Return the laws of a case and a family of mechanisms on which all can act.

    The first law goes through all of them in turn, so that each is left out equally often.
    """
    if about.drives:
        return (), str(rng.choice(["six_joint_arm", "seven_joint_arm"]))
    count = about.count(seed, number)
    if count == 0:
        return (), str(rng.choice([each for each in FAMILIES if _suits(about, each)]))
    library = about.outside_laws() if count < 0 else about.laws()
    kin = sum((about.count(seed, each) < 0) == (count < 0) for each in range(number)
              if about.count(seed, each) != 0)  # fmt: skip
    if about.events:
        library, kin = about.events_of(kin), kin // 2
    turn, place = divmod(kin, len(library))
    order = np.random.default_rng([about.number, seed, 1, turn]).permutation(len(library))
    first = library[int(order[place])]
    wet = {"linear_drag", "quadratic_drag", "added_mass", "buoyancy", "thrust", "fluid_current"}
    far = {"spinning_rotor", "axis_misalignment"}
    small = {"pendulum", "cart_pole", "double_pendulum"}
    turning = {"backlash", "series_elasticity", "coupled_detent"}
    families = [
        family
        for family in FAMILIES
        if _suits(about, family)
        and (first.name not in wet or family == "submerged_arm")
        and (first.name not in far or family not in small)
        and (first.name not in turning or family not in {"pendulum", "cart_pole"})
    ]
    family = str(rng.choice(families))
    laws = [first]
    if first.needs:
        laws.insert(0, next(law for law in LAWS if law.name == first.needs))
    while count > 0 and len(laws) < count:
        other = about.laws()[int(rng.integers(len(about.laws())))]
        if other.name not in {law.name for law in laws} and other.needs is None:
            if other.name in wet and family != "submerged_arm":
                continue
            laws.append(other)
    return tuple(laws), family


def _suits(about: Suite, family: str) -> bool:
    """Return whether a mechanism keeps an encoder where one is taken away."""
    return len(about.ways) == 1 or family != "pendulum"


def _perturb(
    plant: Plant, vary: Mapping[str, float], rng: np.random.Generator
) -> tuple[Plant, dict[str, tuple[float, ...]]]:
    """Return the true plant, whose figures differ from the described, and the factors."""
    factors = {kind: 1 + f * rng.uniform(-1, 1, plant.count) for kind, f in vary.items()}
    true = plant.with_body(slice(None), mass=plant.of_body("mass") * factors["mass"])
    true = true.with_com(slice(None), plant.com * factors["com"][:, None])
    true = replace(true, inertia=plant.inertia * factors["inertia"][:, None, None])
    true = true.with_joint(slice(None), gain=factors["gain"])
    return true, {kind: tuple(float(f) for f in each) for kind, each in factors.items()}


def _add(
    truth: Truth, law: Law, scales: Scales, vary: Mapping[str, float],
    rng: np.random.Generator, seconds: float,
) -> Truth:  # fmt: skip
    """Return the truth with one more effect, at a place and of a size drawn at random."""
    mechanism = truth.mechanism
    places = [
        i
        for i in (range(1) if law.kind == "world" else range(mechanism.plant.count))
        if law.acts(mechanism, i) and not _excluded(truth, law, i)
    ]
    if law.needs:
        places = [0]
    for place in rng.permutation(places)[:3]:
        setting = Setting(
            mechanism=mechanism, plant=truth.base, scales=scales, place=int(place),
            chance=rng.random(8), vary=vary, seconds=seconds,
        )  # fmt: skip
        run = int(rng.integers(len(truth.runs) - 1)) if law.name == "external_push" else None
        target = float(np.exp(rng.uniform(np.log(3.0), np.log(60.0))))
        try:
            return size_for(truth, law, setting, run, target)
        except NoSize:
            continue
    raise NoSize(f"{law.name} cannot be seen", where=mechanism.family, fix="draw another case")


def _begun(
    truth: Truth, motions: tuple[Motion, ...], rng: np.random.Generator
) -> tuple[Truth, tuple[Motion, ...]]:
    """Return a truth whose lasting effects begin in the middle of a training run but the first.

    They are as strong as if they acted in all.
    """
    run = int(rng.integers(1, len(truth.runs) - 1))
    since = run, int(rng.uniform(0.2, 0.8) * truth.runs[run].grids)
    effects = tuple(replace(e, since=since) if e.run is None else e for e in truth.effects)
    if effects == truth.effects:
        return truth, motions
    truth = replace(truth, effects=effects)
    try:
        return truth, tuple(truth.move(each, FINEST) for each in range(len(truth.runs)))
    except NoSize:
        raise
    except BenchmarkError as error:
        raise NoSize("the motion diverges", where="begun", fix="redraw") from error


def _excluded(truth: Truth, law: Law, place: int) -> bool:
    there = {effect.law.name for effect in truth.effects if effect.place == place}
    return any(law.name in group and there & group for group in EXCLUSIVE)


def _real_drives(
    truth: Truth, scales: Scales, vary: Mapping[str, float], rng: np.random.Generator,
    seconds: float,
) -> Truth:  # fmt: skip
    """Return an arm with stiction, load-dependent friction and flexible drives at every joint.

    A load hangs at its last link. Figures are drawn directly: friction from 5 to 20 % of the
    usual effort, springs on which the rotor alone swings at half to twice `SWING`.

    Source: Modelica Standard Library, MultiBody.Examples.Systems.RobotR3, AxisType1 (the Manutec
    r3): 43 N m/rad and 0.0013 kg m2 at the motor, damped by 0.005 N m s/rad, 1 % of critical.
    """
    by_name = {law.name: law for law in LAWS}
    effects = []

    def put(name: str, place: int, size: float, **figures: float) -> None:
        setting = Setting(
            mechanism=truth.mechanism, plant=truth.base, scales=scales, place=place,
            chance=rng.random(8), vary=vary, seconds=seconds,
        )  # fmt: skip
        law = by_name[name]
        figures = figures or dict(law.figures(size, setting))
        effects.append(Effect(law=law, place=place, figures=figures))

    for place in truth.mechanism.driven:
        put("stribeck_friction", place, rng.uniform(0.05, 0.2))
        put("load_dependent_friction", place, rng.uniform(0.02, 0.1))
        rotor = float(truth.base.of_joint("rotor")[place])
        rate = SWING * 2.0 ** rng.uniform(-1.0, 1.0)
        damped = 0.01 * 10.0 ** rng.uniform(0.0, 1.0)
        put("series_elasticity", place, 0.0, k=rotor * rate**2, d=2.0 * damped * rotor * rate)
    put("payload", truth.mechanism.plant.count - 1, rng.uniform(1.0, 3.0))
    return replace(truth, effects=tuple(effects))
