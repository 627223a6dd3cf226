"""A policy on a target that differs, as `morph loop` tries and repairs it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from morph.extras import require

if TYPE_CHECKING:
    from morph.app.report.loop.outcome import LoopOutcome


def loop(
    task: str,
    robot: str | Path,
    out: str | Path,
    *,
    policy: str | Path | None = None,
    change: Sequence[str] = (),
    effect: Sequence[str] = (),
    sealed: int | None = None,
    trials: int = 5,
    seed: int = 0,
    fresh: bool = False,
) -> LoopOutcome:
    """Return what became of a policy on a target that differs: tried, diagnosed, repaired, retried.

    Args:
        task: A name from `morph list tasks`.
        robot: The source, as `morph.load` takes it.
        out: Folder for the policy, the corrected model, the trials and a report.
        policy: Folder of the source's policy; by default it is learned first.
        change: Figures in which the target differs, as `length:pole=2`.
        effect: Physics of the target alone, as `viscous_friction@hinge:b=0.1`.
        sealed: Random seed from which differences are drawn, instead of `change` and `effect`; they
            are shown only at the end.
        trials: Most trials on the target.
        seed: Random seed of all else.
        fresh: Begin anew in a folder that holds an earlier loop.

    Raises:
        MorphError: An input cannot be used, or a result cannot be written.
    """
    require("learn", "morph.loop")
    from morph.app.cli.arguments import Loop
    from morph.app.cli.loop import looped

    return looped(
        Loop(
            task=task,
            robot=str(robot),
            out=str(out),
            policy=None if policy is None else str(policy),
            change=tuple(change),
            effect=tuple(effect),
            sealed=sealed,
            trials=trials,
            seed=seed,
            fresh=fresh,
            quiet=True,
        )
    )
