"""One case of the study: a chain at a seed with its controls and rivals, or the best of a body."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from experiments.swim.water import aqua_water
from morph.errors import MorphError
from morph.policy_transfer.gait.controls import CONTROLS, control
from morph.policy_transfer.gait.direct import direct
from morph.policy_transfer.gait.free import free
from morph.policy_transfer.gait.hop import Budget, family_of, felt
from morph.policy_transfer.gait.mover import Mover
from morph.policy_transfer.gait.relay import Chained, relay
from morph.policy_transfer.gait.swimmers import swimmer
from morph.policy_transfer.gait.walkers import walker
from morph.search.family.family import Family
from morph.search.family.gait import gait

CHAINS: Mapping[str, tuple[str, ...]] = {
    "aqua": ("swimmer_three_links", "sea_snake_planar", "sea_snake", "hexapod_swimmer"),
    "aracna": (
        "quadruped_printed",
        "quadruped_wide",
        "quadruped_loaded",
        "quadruped_four_bar",
    ),
    "urma": ("swimmer_three_links", "sea_snake_planar", "sea_snake", "urma_sea_snake"),
}
"""The bodies of each chain; the first learns by itself."""

PADDLED = "hexapod_swimmer"
"""The body whose paddles push by Lighthill's force, in the water that is published for AQUA."""

REAL = Path("urma_sea_snake") / "sea_snake.xml"
"""The real description, within the folder of real robots."""

SIGMAS = (0.1, 0.2, 0.35)
"""Step sizes of direct learning."""

ORACLE_SEED = 900
"""Chance of the searches for the best, which no chain sees."""

ENOUGH = 0.95
"""Share of the best at which a gait counts as learned."""


RIVAL = {True: "free", False: "names"}
"""In what direct learning searches, in water and on a floor: in water the other was tried once and
was far worse, on a floor it was not tried."""


@dataclass(frozen=True, kw_only=True)
class Size:
    """How much is run."""

    learning: int = 150
    """Trials of the first body."""
    trials: int = 32
    """Trials of each hop and of each control."""
    direct: int = 320
    """Most trials of direct learning."""
    oracle: int = 300
    """Trials of each of the searches for the best."""
    polish: int = 150
    """Trials near the best that each of them found."""
    sigmas: tuple[float, ...] = SIGMAS
    """Its step sizes."""
    controls: tuple[str, ...] = CONTROLS
    """What runs beside the last hop."""


@dataclass(frozen=True, kw_only=True)
class Job:
    """A chain at a seed, or the best of a body."""

    kind: str
    """`case` or `best`."""
    name: str
    """Of the chain or of the body."""
    seed: int
    """Of all chance."""
    real: str
    """Folder of the real robots; empty if no chain needs one."""
    size: Size
    """How much is run."""


FULL = Size()
QUICK = Size(
    learning=10, trials=8, direct=10, oracle=10, polish=10, sigmas=(0.2,),
    controls=("shuffled", "no_source"),
)  # fmt: skip


@cache
def body(name: str, real: str) -> Mover:
    """Return a body of a chain; the real one is read from the folder of real robots."""
    if name == "urma_sea_snake":
        return swimmer(Path(real) / REAL)
    if name.startswith("quadruped"):
        return walker(name)
    made = swimmer(name)
    if name != PADDLED:
        return made
    return replace(made, task=replace(made.task, effects=aqua_water(made.robot)))


def budget_of(mover: Mover, trials: int = FULL.trials) -> Budget:
    """Return what a hop may cost; feet that are swung too far slip, and tell little."""
    if mover.wet:
        return Budget(trials=trials)
    return Budget(trials=trials, transitions=40, width=0.3)


def families(mover: Mover) -> Mapping[str, Family]:
    """Return what direct learning searches in: servo by servo, or by the servos' names."""
    period = mover.task.period
    return {
        "free": free(mover.action, period=period),
        "names": gait(mover.robot, period=period, action=mover.action),
    }


def best_of(name: str, real: str, size: Size) -> dict[str, Any]:
    """Return the greatest speed that long searches find on a body, m/s."""
    mover = body(name, real)
    limbs, _, _ = felt(mover, budget_of(mover), np.random.default_rng(ORACLE_SEED))
    searched: dict[str, Family] = {**families(mover), "waves": family_of(mover, limbs)}
    found = {}
    for label, family in searched.items():
        first = direct(mover, family, trials=size.oracle, sigma=0.25, seed=ORACLE_SEED)
        again = direct(
            mover,
            family,
            trials=size.polish,
            sigma=0.08,
            seed=ORACLE_SEED + 1,
            start=first.point[int(first.speed.argmax())],
        )
        found[label] = max(first.best, again.best)
    return {"case": f"best {name}", "best": found}


def case(chain: str, seed: int, real: str, size: Size) -> dict[str, Any]:
    """Return what one chain comes to at one seed, with its controls and direct learning."""
    movers = [body(name, real) for name in CHAINS[chain]]
    budget = budget_of(movers[0], size.trials)
    made = relay(movers, seed=seed, learning=size.learning, budget=budget)
    source, last = made.bodies[-2:]
    rng = np.random.default_rng([seed, 99])
    beside = {
        name: control(name, source, last, rng=rng, budget=budget).speeds.tolist()
        for name in size.controls
    }
    learned = {
        f"{label} {sigma:g}": direct(
            last.mover, family, trials=size.direct, sigma=sigma, seed=seed
        ).speed.tolist()
        for label, family in families(last.mover).items()
        if label == RIVAL[last.mover.wet]
        for sigma in size.sigmas
    }
    return {
        "case": f"{chain} {seed}",
        "chain": chain,
        "seed": seed,
        "hops": _hops(made),
        "controls": beside,
        "direct": learned,
        "trial": last.mover.trial,
    }


def _hops(made: Chained) -> list[dict[str, Any]]:
    return [
        {
            "body": each.mover.robot.name[:60],
            "speed": each.speed,
            "speeds": each.speeds.tolist(),
            "samples": each.samples,
            "values": each.values.tolist(),
        }
        for each in made.bodies
    ]


def job(what: Job) -> dict[str, Any]:
    """Return what one job comes to; what cannot be done is a row that says why."""
    try:
        if what.kind == "best":
            return best_of(what.name, what.real, what.size)
        return case(what.name, what.seed, what.real, what.size)
    except MorphError as error:
        where = {"case": f"{what.name} {what.seed}", "chain": what.name, "seed": what.seed}
        return where | {"failed": str(error)}
