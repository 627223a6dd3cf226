"""Baselines: what others would do with a case, each from its folder to an answer."""

from __future__ import annotations

import json
import time
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from sklearn.exceptions import ConvergenceWarning
from sklearn.linear_model import LassoLarsIC, lasso_path

from experiments.concealed.predict import STEP, HeldOut, Predicted, predicted
from experiments.concealed.seal import open_seal
from experiments.concealed.submission import JSON, submission
from experiments.incumbent import MOST, by_sysid
from experiments.openloop import from_mjcf
from morph.arrays import Array
from morph.body.load import load as load_robot
from morph.body.robot import Robot
from morph.inference.bounded import bounded
from morph.inference.columns import Columns
from morph.inference.dictionary import dictionary
from morph.inference.effect_selection import DRY
from morph.inference.inverse_dynamics import likeliest_forces, weighed_forces
from morph.inference.refit import Refit, refitted, seen
from morph.model.corrected import corrected
from morph.model.episodes import Episode, episode, step_for
from morph.model.hypothesis import Hypothesis
from morph.model.nuisance_parameters import knobs
from morph.model.residual import learned
from morph.physics import EFFECTS
from morph.physics.effect import Effect
from morph.record.load import load_recordings

FELT = 0.1
"""Least share of the explained torque's RMS that an effect of LASSO must have to be named."""
SYSID_STEPS, SYSID_PIECE = 15, 1.0
"""Most iterations of `mujoco.sysid`, and seconds of the rollouts that it fits."""
TOLD = {
    "viscous_friction": "damping",
    "coulomb_friction": "frictionloss",
    "armature": "armature",
}
"""Figures of a joint by which `mujoco.sysid` can fit a law; it fits links' figures in any case."""


@dataclass(frozen=True, kw_only=True)
class _Task:
    """A case as a solver reads it."""

    robot: Robot
    episodes: list[Episode]
    nominal: Hypothesis
    begin: float

    @classmethod
    def read(cls, folder: Path) -> _Task:
        """Return the case in a folder."""
        begin, known = time.process_time(), json.loads((folder / "case.json").read_text())
        robot = load_robot(str(folder / known["description"]))
        recordings = load_recordings(folder / "recordings", robot=robot)
        step = step_for(recordings, robot)
        return cls(
            robot=robot,
            episodes=[episode(each, robot, step) for each in recordings],
            nominal=Hypothesis(robot=robot, step=step, knobs=knobs(robot, known["vary"])),
            begin=begin,
        )

    def answer(
        self,
        folder: Path,
        solver: str,
        readings: Predicted,
        effects: Sequence[Effect] = (),
        *,
        unknown: float = 0.0,
    ) -> JSON:
        """Return an answer that names effects, sure of each, and predicts readings."""
        return submission(
            folder.name,
            solver,
            seconds=time.process_time() - self.begin,
            findings=[
                {"effect": each.name, "where": each.where, "probability": 1.0} for each in effects
            ],
            none=float(not effects and unknown == 0.0),
            unknown=unknown,
            predicted=readings,
        )

    def refit(self) -> Refit:
        """Return the description with its own parameters refitted by `morph.inference`."""
        return refitted(self.nominal, self.nominal.start, self.episodes, rounds=5)


def _by_model(folder: Path, hypothesis: Hypothesis, point: Array) -> Predicted:
    beside, mjcf = corrected(hypothesis, point)
    return predicted(folder, from_mjcf(mjcf), beside)


def refit_own_figures(folder: Path, seed: int) -> JSON:
    """Return the description with masses, centres, inertias and gains refitted, and no law."""
    task = _Task.read(folder)
    found = task.refit()
    return task.answer(folder, "refit", _by_model(folder, found.hypothesis, found.point))


def _lasso(table: Array, goal: Array) -> Array:
    """Return the coefficients of LASSO at the penalty of least BIC, shape (columns,).

    Least angle regression breaks in scikit-learn 1.9 where columns that it drops make up others:
    coordinate descent stands in, at 60 penalties.
    """
    try:
        fitted = LassoLarsIC(criterion="bic", max_iter=60).fit(table, goal)
    except ValueError:
        centred, rest = table - table.mean(axis=0), goal - goal.mean()
        _, path, _ = lasso_path(centred, rest, alphas=60)
        left = ((rest[:, None] - centred @ path) ** 2).mean(axis=0)
        bic = len(goal) * np.log(left) + (path != 0.0).sum(axis=0) * np.log(len(goal))
        return np.asarray(path[:, int(np.argmin(bic))])
    return np.asarray(fitted.coef_)


def solve_by_lasso(folder: Path, seed: int) -> JSON:
    """Return the laws of the same dictionary that LASSO picks on torques of inverse dynamics.

    The penalty is chosen by Schwarz's criterion, as is usual where sparse regression identifies
    dynamics; laws on sensors and commands give no torque and are out of its reach.

    Source: Zou, Hastie and Tibshirani 2007, Annals of Statistics 35(5), 2173-2192.
    """
    task = _Task.read(folder)
    refit = task.refit()
    runs, shapes, columns = refit.runs, [], []
    for grid in dictionary(task.robot, runs, ()):
        for effect in grid:
            if effect.kind != "sensor":
                parts = [effect.regressor(run.motion) for run in runs]
                stacked = np.concatenate([part.reshape(-1, part.shape[2]) for part in parts])
                shapes += [(effect, k) for k in range(stacked.shape[1])]
                columns.append(stacked)
    # What the smoothed motion needs beyond the model is the force that the smoother left over.
    missing = np.concatenate([run.about.force.reshape(-1) for run in runs])
    rows = slice(None, None, max(1, len(missing) // 20000))
    table = np.concatenate(columns, axis=1)[rows]
    size = np.sqrt(np.mean(table**2, axis=0)) + 1e-12
    with warnings.catch_warnings():
        # A column that others make up is dropped, with a warning.
        warnings.simplefilter("ignore", ConvergenceWarning)
        found = _lasso(table / size, missing[rows])
    share = np.abs(found) / (np.sqrt(np.mean(missing**2)) + 1e-12)
    best: dict[str, tuple[float, Effect]] = {}
    for effect in dict.fromkeys(effect for effect, _ in shapes):
        mine = [at for at, (other, _) in enumerate(shapes) if other == effect]
        felt = float(share[mine].max())
        if felt > max(FELT, best.get(effect.label, (0.0,))[0]):
            strengths = np.array([found[at] / size[at] for at in mine])
            best[effect.label] = felt, effect.with_strengths(strengths)
    effects: tuple[Effect, ...] = ()
    for _, effect in sorted(best.values(), key=lambda each: -each[0]):
        # Of pushes there is one a run.
        if len(effects) < 5 and all(effect.beside(other) for other in effects):
            effects = (*effects, effect)
    whole = Hypothesis(robot=task.robot, step=task.nominal.step, knobs=(), effects=effects)
    return task.answer(folder, "lasso", _by_model(folder, whole, whole.start), effects)


def solve_by_residual(folder: Path, seed: int) -> JSON:
    """Return a learned force alone beside the description: it predicts, and names nothing."""
    task = _Task.read(folder)
    force = learned(task.nominal, task.nominal.start, task.episodes, seed)
    return task.answer(folder, "gp", predicted(folder, task.robot, (force,)), unknown=1.0)


def solve_by_inverse_dynamics(folder: Path, seed: int) -> JSON:
    """Return friction and loads by least squares of inverse dynamics that is told which act where.

    It is the estimator of `morph.inference` without its search; of each finding its first figure is
    stated. Flexible drives, and laws on sensors and commands, are out of its reach.

    Source: Swevers, Verdonck and De Schutter 2007, IEEE Control Systems 27(5), 58-71.
    """
    task = _Task.read(folder)
    truth = open_seal(folder).about
    acting = sorted((effect["effect"], effect["where"]["name"]) for effect in truth["effects"])
    kinds = {kind.name: kind for kind in EFFECTS}
    told = [kinds[name].at(where) for name, where in acting if name in {*DRY, "payload"}]
    nominal, count = task.nominal, len(task.nominal.knobs)
    runs = seen(nominal, nominal.start, task.episodes)
    # A load of no mass is nowhere: strengths begin where linear least squares has them.
    linear, _ = weighed_forces(Columns.of(nominal, nominal.start), [(e,) for e in told], runs)
    rows = np.concatenate([run.rows.reshape(-1, run.rows.shape[2]) for run in linear])
    bounds = [(nominal.low, nominal.high), *(effect.coefficient_bounds() for effect in told)]
    low, high = (np.concatenate(side) for side in zip(*bounds, strict=True))
    inner, ends = rows[:, 1:].T @ rows[:, 1:], np.cumsum([len(each) for each, _ in bounds])[:-1]
    inner[:count, :count] += np.diag(nominal.trust)
    best, _ = bounded(inner, rows[:, 1:].T @ rows[:, 0], low - 1e-9, high + 1e-9)
    own, *strengths = np.split(best, ends)
    told = [e.with_strengths(c) for e, c in zip(told, strengths, strict=True)]
    start = replace(nominal, effects=tuple(told))
    found = likeliest_forces(start, np.r_[own, start.start[count:]], runs)
    effects = start.effects_at(found.point)
    answer = task.answer(folder, "idim", _by_model(folder, start, found.point), effects)
    deviation = np.sqrt(np.maximum(np.diag(np.linalg.pinv(found.inner(), hermitian=True)), 0.0))
    at = count
    for stated, effect in zip(answer["findings"], effects, strict=True):
        first = effect.free()[0].name
        value, half = getattr(effect, first), 1.645 * float(deviation[at])
        stated["parameters"] = {
            first: {"value": value, "low90": value - half, "high90": value + half}
        }
        at += len(effect.free())
    return answer


def solve_by_sysid(folder: Path, seed: int) -> JSON:
    """Return what `mujoco.sysid` fits that is told which law is missing, where it has that law."""
    task = _Task.read(folder)
    truth = open_seal(folder).about
    told = {TOLD.get(effect["effect"], "") for effect in truth["effects"]}
    fixed = [figure for figure in MOST if figure not in told]
    model, _ = by_sysid(
        task.robot, task.episodes, piece=SYSID_PIECE, iterations=SYSID_STEPS, fixed=fixed
    )
    return task.answer(folder, "sysid", predicted(folder, model.robot, model.effects))


def solve_by_sindy(folder: Path, seed: int) -> JSON:
    """Return sparse equations of motion by `pysindy`, without a description: they name nothing.

    Accelerations are sought among products of two of sin q, cos q, v and the commands.

    Source: Brunton, Proctor and Kutz 2016, PNAS 113(15), 3932-3937.
    """
    import pysindy  # type: ignore[import-untyped]

    task = _Task.read(folder)
    states, slopes, sent = [], [], []
    for run in task.episodes:
        smooth = pysindy.SmoothedFiniteDifference()
        velocity = smooth._differentiate(run.position, run.time)
        states.append(_features(run.position, velocity))
        slopes.append(smooth._differentiate(velocity, run.time))
        rows = np.clip((run.time / run.step).astype(int), 0, len(run.command) - 1)
        sent.append(run.command[rows])
    model = pysindy.SINDy(
        optimizer=pysindy.STLSQ(threshold=0.05, alpha=1e-3, normalize_columns=True),
        feature_library=pysindy.PolynomialLibrary(degree=2),
    )
    times = [run.time for run in task.episodes]
    model.fit(states, t=times, x_dot=slopes, u=sent)
    held_out = HeldOut.read(folder, task.robot)
    joints = [joint.name for joint in task.robot.joints]
    commands = held_out.windows(list(held_out.command.values()))
    q = np.stack([held_out.reading[joint] for joint in joints], axis=1)
    v = np.stack([held_out.rate[joint] for joint in joints], axis=1)
    path = [q]
    with np.errstate(over="ignore", invalid="ignore"):
        for step in range(commands.shape[1]):
            slope = model.predict(_features(q, v), u=commands[:, step])
            v = v + STEP * np.clip(np.nan_to_num(slope), -1e4, 1e4)
            q = q + STEP * v
            path.append(q)
    moved = np.stack(path, axis=1)
    shown = {f"{j}.position": held_out.shown(j, moved[:, :, i]) for i, j in enumerate(joints)}
    return task.answer(folder, "sindy", shown, unknown=1.0)


def _features(position: Array, velocity: Array) -> Array:
    return np.concatenate([np.sin(position), np.cos(position), velocity], axis=-1)
