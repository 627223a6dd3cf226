"""How far, and how surely, models of a changed cart-pole with concealed physics foresee its runs.

python -m experiments.residual --seeds 100 110
python -m experiments.residual --quick
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from experiments.figures.result_file import figure_name
from experiments.figures.save_options import parse_and_save
from experiments.residual_rivals import deterministic, gaussian_process, mapped
from experiments.transfer.changed import cartpole
from morph.arrays import JSON, Array
from morph.body.load import load
from morph.model.hypothesis import Hypothesis
from morph.model.latent.run import Run
from morph.model.latent.unknowns import unknowns
from morph.model.missing_force.calibrate import BLOCK, calibrated, calibration, ranks
from morph.model.missing_force.corrected import Corrected
from morph.model.missing_force.fit import fit
from morph.model.missing_force.periods import Periods
from morph.physics.effect import Effect
from morph.physics.joint.coulomb_friction import CoulombFriction
from morph.physics.joint.joint_stiffness import JointStiffness
from morph.physics.joint.quadratic_damping import QuadraticDamping
from morph.search.target import Simulated
from morph.sim.threads import one_thread
from morph.task.swing_up import swing_up
from morph.task.task import Task

CASES = ("none", "dry", "drag", "spring", "mixed")
"""What is concealed: nothing, dry friction, quadratic damping, a spring, or two of these."""

HORIZONS = (1, 5, 10, 20)
"""Control periods ahead at which errors are reported."""

DRAWS = 64
"""Possible runs by which each forecast is made."""

OURS = "the same, calibrated"
"""The model whose scores are told while the study runs."""

WIDTHS = {"gain": 0.03, "gravity": 0.03}
"""What is believed of figures that are well known; of others 0.3."""

Forecast = Callable[[Array, Array, np.random.Generator], Array]
"""From starts (runs, n), commands (runs, periods, nu) and chance to states (draws, ...)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class World:
    """One concealed cart-pole: runs to learn from, and runs to foresee."""

    learned: list[Run]
    """What models are fitted to."""
    start: Array
    """Starts of what is to be foreseen, as observed, shape (blocks, n)."""
    command: Array
    """Shape (blocks, periods, nu)."""
    observed: Array
    """What came, shape (blocks, periods + 1, n)."""


def concealed(case: str, rng: np.random.Generator) -> tuple[Effect, ...]:
    """Return physics that no model is told of, its strength drawn."""
    much = rng.uniform(0.5, 1.5, 4)
    dry = (
        CoulombFriction(joint="hinge", c=0.05 * much[0]),
        CoulombFriction(joint="slide", c=0.8 * much[1]),
    )
    drag = (
        QuadraticDamping(joint="hinge", b2=0.004 * much[0]),
        QuadraticDamping(joint="slide", b2=0.5 * much[1]),
    )
    spring = (JointStiffness(joint="hinge", k=0.3 * much[2]),)
    mixed = (dry[0], drag[1])
    return {"none": (), "dry": dry, "drag": drag, "spring": spring, "mixed": mixed}[case]


def figures_off(rng: np.random.Generator) -> dict[str, float]:
    """Return by what factors the masses and the length are off, up to a quarter."""
    return dict(zip(("m", "l", "M"), np.exp(rng.uniform(-0.22, 0.22, 3)), strict=True))


def hypothesis_of() -> tuple[Task, Hypothesis]:
    """Return the task as described, and what may be wrong of its body."""
    robot = load("cartpole")
    task = swing_up(robot)
    knobs = tuple(replace(k, fraction=WIDTHS.get(k.what, 0.3)) for k in unknowns(robot))
    return task, Hypothesis(robot=robot, step=task.step, knobs=knobs)


def world(case: str, seed: int, *, learned: int = 2, foreseen: int = 5) -> World:
    """Return a cart-pole whose masses and length are off by up to a quarter, and its runs."""
    rng = np.random.default_rng([seed, CASES.index(case)])
    task = swing_up(cartpole(figures_off(rng)))
    target = Simulated(task=task, simulator=task.simulator(concealed(case, rng)))
    runs = [target.trial(commands(rng), rng).run for _ in range(learned + foreseen)]
    blocks = [
        (run.state[at : at + BLOCK + 1], run.command[at : at + BLOCK])
        for run in runs[learned:]
        for at in range(0, len(run.command) - BLOCK + 1, BLOCK)
    ]
    observed = np.stack([state for state, _ in blocks])
    command = np.stack([told for _, told in blocks])
    return World(learned=runs[:learned], start=observed[:, 0], command=command, observed=observed)


def commands(rng: np.random.Generator) -> Array:
    """Return 3 s of commands that are drawn anew each 0.2 s, up to 8 N."""
    return np.repeat(rng.uniform(-8.0, 8.0, (15, 1)), 4, axis=0)


def forecasts(seen: World, rng: np.random.Generator) -> dict[str, tuple[Forecast, float]]:
    """Return every model's forecast, and the seconds of processor that its fit took."""
    task, hypothesis = hypothesis_of()
    periods = Periods(hypothesis, task.period, task.integrator)
    noise = np.full(2 * periods.nv, task.noise)
    nominal = deterministic(periods, hypothesis.start)
    found: dict[str, tuple[Forecast, float]] = {}
    models: dict[str, Corrected] = {}

    def add(name: str, made: Callable[[], Forecast]) -> None:
        begun = time.process_time()
        forecast = made()
        found[name] = forecast, time.process_time() - begun

    def joint(*, force: bool) -> Forecast:
        model = fit(hypothesis, seen.learned, noise=noise, force=force, integrator=task.integrator)
        models["force" if force else "figures"] = model
        return _of(model)

    def right() -> Forecast:
        models["right"] = calibrated(models["force"], seen.learned, rng)
        return _of(models["right"])

    def turned() -> Forecast:
        model, size = models["force"], len(hypothesis.start)
        mean = model.posterior.mean.copy()
        mean[size:] *= -1.0
        there = replace(model.posterior, b=model.posterior.H @ mean)
        return _of(replace(model, weight=-model.weight, posterior=there))

    def plain(simulate: Callable[[Array, Array], Array] | None, *, shuffled: bool) -> Forecast:
        return gaussian_process(
            seen.learned, noise, simulate, rng if shuffled else None, draws=DRAWS
        )

    add("simulator alone", lambda: deterministic_forecast(nominal, noise))
    add("simulator refitted", lambda: joint(force=False))
    refitted = deterministic(periods, models["figures"].point)
    add("Gaussian process alone", lambda: plain(None, shuffled=False))
    add("plain residual on the refit", lambda: plain(refitted, shuffled=False))
    add("the same, targets shuffled", lambda: plain(refitted, shuffled=True))
    add("map of predictions (eq. 10)", lambda: mapped(seen.learned, noise, nominal, draws=DRAWS))
    add("figures and force together", lambda: joint(force=True))
    add(OURS, right)
    add("the same, force turned round", turned)
    return found


def _of(model: Corrected) -> Forecast:
    return lambda start, command, rng: model.foresee(start, command, rng, draws=DRAWS).states


def deterministic_forecast(simulate: Callable[[Array, Array], Array], noise: Array) -> Forecast:
    """Return the forecast of a simulator that doubts nothing but where a run starts."""

    def forecast(start: Array, command: Array, rng: np.random.Generator) -> Array:
        now = start + noise * rng.normal(size=(DRAWS, *start.shape))
        found = [now]
        for at in range(command.shape[1]):
            told = np.broadcast_to(command[:, at], (DRAWS, *command[:, at].shape))
            flat = simulate(now.reshape(-1, now.shape[-1]), told.reshape(-1, told.shape[-1]))
            now = flat.reshape(now.shape)
            found.append(now)
        return np.stack(found, axis=2)

    return forecast


def scored(case: str, seed: int) -> dict[str, JSON]:
    """Return each model's errors and ranks on one cart-pole."""
    seen = world(case, seed)
    rng = np.random.default_rng([seed, 99])
    size = seen.observed.std(axis=(0, 1))
    noise = np.full(seen.start.shape[1], 0.01)
    scores: dict[str, JSON] = {}
    for name, (forecast, seconds) in forecasts(seen, rng).items():
        states = forecast(seen.start, seen.command, rng)
        with np.errstate(all="ignore"):
            off = (np.nanmean(states, axis=0) - seen.observed) / size
        # A forecast that ran away is as wrong as one that says nothing of ten sizes.
        off = np.clip(np.nan_to_num(off, nan=10.0), -10.0, 10.0)
        rank = ranks(states + noise * rng.normal(size=states.shape), seen.observed)[:, 1:]
        found = calibration(rank)
        scores[name] = {
            "error": [float(np.sqrt((off[:, at] ** 2).mean())) for at in HORIZONS],
            "calibration": found.error,
            "covered": found.covered(0.96),
            "ranks": rank.ravel().tolist(),
            "seconds": seconds,
        }
    return scores


def table(results: Mapping[str, Sequence[dict[str, JSON]]]) -> str:
    """Return the scores of all cases as text: medians over seeds, and calibration pooled."""
    lines = []
    for case, seeds in results.items():
        lines += [
            f"\nconcealed: {case} ({len(seeds)} seeds)",
            f"{'model':30}"
            + "".join(f"{f'{h} ahead':>10}" for h in HORIZONS)
            + f"{'calib.':>9}{'a seed':>9}{'in .96':>9}{'s':>7}",
        ]
        for name in seeds[0]:
            each = [seed[name] for seed in seeds]
            error = np.median([one["error"] for one in each], axis=0)
            pooled = calibration(np.concatenate([one["ranks"] for one in each]))
            lines.append(
                f"{name:30}"
                + "".join(f"{value:10.4f}" for value in error)
                + f"{pooled.error:9.3f}{np.median([one['calibration'] for one in each]):9.3f}"
                + f"{pooled.covered(0.96):9.3f}{np.median([one['seconds'] for one in each]):7.1f}"
            )
    return "\n".join(lines)


def headline(results: Mapping[str, Sequence[dict[str, JSON]]]) -> JSON:
    """Return what a result file holds: median errors at the last horizon, and calibration."""
    figures: JSON = {}
    controls: JSON = {}
    for case, seeds in results.items():
        for name in seeds[0]:
            each = [seed[name] for seed in seeds]
            pooled = calibration(np.concatenate([one["ranks"] for one in each]))
            error = float(np.median([one["error"][-1] for one in each]))
            told = {"error": error, "calibration": pooled.error, "covered": pooled.covered(0.96)}
            if name == OURS:
                figures |= {f"{case}_{key}": value for key, value in told.items()}
            else:
                controls[f"{case}_{figure_name(name)}"] = told
    short = _short(results)
    rows = [{"case": case, "models": each} for case, seeds in short.items() for each in seeds]
    return {"figures": figures, "controls": controls, "rows": rows}


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the study."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.residual",
        description=(__doc__ or "").splitlines()[0],
        epilog="example: python -m experiments.residual --seeds 100 110 --save-as FILE",
    )
    parser.add_argument("--seeds", type=int, nargs=2, default=(100, 110), metavar=("FROM", "TO"))
    parser.add_argument("--cases", nargs="+", choices=CASES, default=list(CASES))
    parser.add_argument("--quick", action="store_true", help="one seed of one case")
    told, save = parse_and_save(parser, arguments, module="experiments.residual")
    cases = ["dry"] if told.quick else told.cases
    seeds = range(100, 101) if told.quick else range(*told.seeds)
    results: dict[str, list[dict[str, JSON]]] = {}
    for case in cases:
        for seed in seeds:
            begun = time.perf_counter()
            with one_thread():
                results.setdefault(case, []).append(scored(case, seed))
            took = time.perf_counter() - begun
            ours = results[case][-1][OURS]
            said = f"20 ahead {ours['error'][-1]:.3f}, calibration {ours['calibration']:.3f}"
            print(f"{case} {seed}: {said}, {took:.0f} s", file=sys.stderr, flush=True)
    if save:
        save(**headline(results), seeds=seeds)
    print(table(results))


def _short(results: Mapping[str, Sequence[dict[str, JSON]]]) -> JSON:
    return {
        case: [
            {name: {k: v for k, v in one.items() if k != "ranks"} for name, one in seed.items()}
            for seed in seeds
        ]
        for case, seeds in results.items()
    }


if __name__ == "__main__":
    main()
