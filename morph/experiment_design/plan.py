"""The cheapest experiments that tell laws apart, before anything is recorded."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import chain

import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.errors import DiagnosisError
from morph.experiment_design.effect_size import sized
from morph.experiment_design.excitation import excitations
from morph.experiment_design.separation import POWER, ExperimentPlan, PlannedRun, Separation, power
from morph.inference.columns import Columns
from morph.inference.design_matrix import believed, effect_columns, whitened_levels
from morph.inference.level import projected
from morph.inference.observed import Observed, observed
from morph.inference.quadratic import information, offset
from morph.model.episodes import episode, step_for
from morph.model.hypothesis import Hypothesis
from morph.model.nuisance_parameters import knobs
from morph.physics.effect import Effect
from morph.record.recording import Channel, Recording

LASTING = 8
"""Lengths of an experiment that are compared, evenly spaced up to the longest."""
UNMODELLED = 0.02
"""Missing force over the inertial force that is expected of the robot even with the right law."""
SHORTEST = 5.0
"""Seconds of the shortest run: a quarter is held out, and rollouts of a second are scored."""
MOST_RUNS = 4
"""Most runs of a plan for all laws."""

Progress = Callable[[str], None]


def plan(
    robot: Robot,
    laws: Sequence[Effect] = (),
    *,
    seconds: float = 20.0,
    rate: float = 100.0,
    noise: float = 5e-4,
    vary: Mapping[str, float] | None = None,
    seed: int = 0,
    progress: Progress = lambda what: None,
) -> ExperimentPlan:
    """Return the cheapest runs that tell two laws apart, or that show every law there can be.

    Motions of several kinds are simulated by the description and linearised, as in a diagnosis:
    columns of laws and of the description's own parameters, whitened by a Kalman filter, say how
    many nats the readings will tell. Nothing is fitted and no reading drawn.

    Source: Lindley 1956, Annals of Mathematical Statistics 27(4); for the discrimination of two
    models Atkinson and Fedorov 1975, Biometrika 62(1), 57-70 (T-optimality).

    Args:
        robot: The description.
        laws: Two laws to tell apart, each at the size that it would have, or neutral for a usual
            one. None: every law at every part, one at a time, and each beside its twins there.
        seconds: The longest that a run may last.
        rate: Readings a second.
        noise: Standard deviation of readings, rad or m.
        vary: Fractions by which the description may be wrong; see `knobs`.
        seed: Random seed of the motions.
        progress: Told what is being done.

    Raises:
        DiagnosisError: An actuator has no limit, no motion is safe, a link falls freely, a setting
            is out of range, or the laws are not two.
        KernelError: There is no C compiler for the Kalman filter.
    """
    _check(laws, seconds, rate, noise, seed)
    progress("simulating motions")
    result = excitations(robot, seconds, _step(robot, rate), seed)
    shown = [replace(each, recording=_read(each.recording, rate)) for each in result]
    nominal = Hypothesis(
        robot=robot,
        step=step_for([each.recording for each in shown], robot),
        knobs=knobs(robot, vary),
    )
    strongest = expected_motion(nominal, shown[0].recording, noise)
    others = (expected_motion(nominal, each.recording, noise) for each in shown[1:])
    grids = sized(robot, laws, chain([strongest], others))
    tables = []
    for number, each in enumerate(shown):
        progress(f"looking at motion {number + 1} of {len(shown)}: {each.kind}")
        seen = strongest if number == 0 else expected_motion(nominal, each.recording, noise)
        tables.append(laws_information(nominal, grids, seen))
    pairs = _pairs(grids, two=bool(laws))
    if not pairs:
        raise DiagnosisError(
            "no law acts in any motion that was tried",
            where=f"robot {robot.name}",
            fix="give a robot whose actuators move it",
        )
    lengths = seconds * np.arange(1, LASTING + 1) / LASTING
    least = int(np.argmax(lengths >= SHORTEST))
    chosen = _cheapest(tables, grids, pairs, least) if laws else _most_telling(tables, grids, pairs)
    whole = np.sum([tables[at][length] for at, length in chosen], axis=0)
    return ExperimentPlan(
        robot=robot,
        runs=tuple(
            PlannedRun(excitation=result[at], seconds=float(lengths[length]))
            for at, length in chosen
        ),
        separations=tuple(sorted(separations_of(whole, grids, pairs), key=lambda each: each.nats)),
        noise=noise,
        unmodelled=UNMODELLED,
        tried=len(result),
    )


def _check(laws: Sequence[Effect], seconds: float, rate: float, noise: float, seed: int) -> None:
    different = len({law.label for law in laws})
    if laws and (len(laws) != 2 or different != 2):
        raise DiagnosisError(
            f"two laws are told apart, and of different ones there are {different}",
            where="--separate",
            fix="name two different laws, as coulomb_friction@elbow viscous_friction@elbow",
        )
    if seed < 0:
        raise DiagnosisError(f"a seed of {seed} is below 0", where="--seed", fix="give 0 or more")
    for value, low, high, where in (
        (seconds, SHORTEST, 600.0, "--seconds"),
        (rate, 5.0, 2000.0, "--rate"),
        (noise, 1e-7, 1.0, "--noise"),
    ):
        if not low <= value <= high:
            raise DiagnosisError(
                f"{value:g} is out of range", where=where, fix=f"give {low:g} to {high:g}"
            )


def _step(robot: Robot, rate: float) -> float:
    """Return a step of simulation that is a whole part of a reading's period, at most 2 ms."""
    return 1.0 / (rate * math.ceil(1.0 / (rate * 0.002)))


def _read(made: Recording, rate: float) -> Recording:
    """Return a simulated motion as it is read: positions and poses, at a rate."""
    channels = {}
    for name, channel in made.channels.items():
        if channel.hold:
            channels[name] = channel
        elif ".position" in name or ".orientation" in name:
            every = max(1, round(1.0 / (rate * float(np.median(np.diff(channel.time))))))
            channels[name] = Channel(time=channel.time[::every], value=channel.value[::every])
    return replace(made, channels=channels)


def expected_motion(nominal: Hypothesis, recording: Recording, noise: float) -> Observed:
    """Return a motion linearised, with the noise and the missing force to reckon with.

    Args:
        nominal: The description.
        recording: A motion of it, simulated.
        noise: Standard deviation of readings, rad or m.
    """
    laid = episode(recording, nominal.robot, nominal.step)
    laid = replace(laid, noise=np.full_like(laid.noise, noise))
    seen = observed(nominal.at(nominal.start).model, nominal.robot, laid)
    about = seen.about
    expected = replace(
        about.disturbance, noise=laid.noise, scale=UNMODELLED * about.inertial, vibration=None
    )
    return replace(seen, about=replace(about, disturbance=expected))


def laws_information(
    nominal: Hypothesis, grids: Sequence[tuple[Effect, ...]], seen: Observed
) -> Array:
    """Return the Gram matrix of laws beside own parameters, by length of the run.

    Shape (lengths, columns, columns): what is left of them when the description's own parameters
    are refitted with what is known of these beforehand.
    """
    own = Columns.of(nominal, nominal.start)
    (folds,) = whitened_levels(own, grids, [seen], LASTING, shares=(1.0,))
    grown = np.cumsum([fold.gram for fold in folds], axis=0)
    trust, at = information(nominal), offset(nominal, nominal.start)
    inside = slice(1, 1 + len(nominal.start))
    results = []
    for gram in grown:
        whole = believed(gram, trust, at)
        rest = projected(whole, whole[inside, inside], whole[inside])
        kept = np.r_[0, 1 + len(nominal.start) : len(whole)]
        results.append(rest[np.ix_(kept, kept)])
    return np.array(results)


def _pairs(grids: Sequence[tuple[Effect, ...]], *, two: bool) -> list[tuple[int, int | None]]:
    """Return which law is to be told from which, by their numbers; None stands for no law."""
    if two:
        return [(0, 1), (1, 0)]
    alone: list[tuple[int, int | None]] = [(at, None) for at in range(len(grids))]
    for at, (law, *_) in enumerate(grids):
        for other, (rival, *_) in enumerate(grids):
            # A law that holds another as a special case explains whatever that does.
            if rival.name in law.twins and rival.where == law.where and rival.simpler != law.name:
                alone.append((at, other))
    return alone


def separations_of(
    gram: Array, grids: Sequence[tuple[Effect, ...]], pairs: Sequence[tuple[int, int | None]]
) -> list[Separation]:
    """Return what a Gram matrix of laws tells apart.

    The expected difference of log likelihoods is half of the square of the law's whitened change of
    the readings, less what the rival explains of it at the shape that explains most.
    """
    places: dict[int, list[Array]] = {}
    columns = list(effect_columns(grids))
    firsts = np.cumsum([0, *(len(grid) for grid in grids)])
    for at, grid in enumerate(grids):
        some = columns[firsts[at] : firsts[at] + len(grid)]
        places[at] = [np.r_[column.place] for column in some]
    results = []
    for at, other in pairs:
        law, mine = grids[at][0], places[at][0]
        size = law.coefficients
        whole = float(size @ gram[np.ix_(mine, mine)] @ size)
        explained = 0.0
        for theirs in () if other is None else places[other]:
            along = gram[np.ix_(theirs, mine)] @ size
            inner = gram[np.ix_(theirs, theirs)]
            explained = max(explained, float(along @ np.linalg.pinv(inner, hermitian=True) @ along))
        results.append(
            Separation(
                law=law.label,
                rival="none" if other is None else grids[other][0].label,
                size={known.name: float(getattr(law, known.name)) for known in law.free()},
                nats=max(0.0, 0.5 * (whole - explained)),
            )
        )
    return results


def _cheapest(
    tables: Sequence[Array],
    grids: Sequence[tuple[Effect, ...]],
    pairs: Sequence[tuple[int, int | None]],
    least: int,
) -> list[tuple[int, int]]:
    """Return the shortest run with power enough, of these the surest; or the surest of all.

    None is shorter than the length of the number `least`.
    """
    worst = np.array(
        [
            [min(e.nats for e in separations_of(gram, grids, pairs)) for gram in table]
            for table in tables
        ]
    )
    sure = np.array([power(most) >= POWER for most in worst.max(axis=0)])
    enough = least + np.flatnonzero(sure[least:])
    length = int(enough[0]) if len(enough) else worst.shape[1] - 1
    return [(int(worst[:, length].argmax()), length)]


def _most_telling(
    tables: Sequence[Array],
    grids: Sequence[tuple[Effect, ...]],
    pairs: Sequence[tuple[int, int | None]],
) -> list[tuple[int, int]]:
    """Return whole runs, each the one that tells most beside those before."""
    chosen: list[tuple[int, int]] = []
    whole, best = np.zeros_like(tables[0][-1]), 0.0
    while len(chosen) < MOST_RUNS:
        sums = [
            sum(e.power for e in separations_of(whole + table[-1], grids, pairs))
            for table in tables
        ]
        for known, _ in chosen:
            sums[known] = 0.0
        at = int(np.argmax(sums))
        if chosen and sums[at] < best + 0.5:
            break
        best, whole = sums[at], whole + tables[at][-1]
        chosen.append((at, len(tables[at]) - 1))
    return chosen
