"""A policy along a chain of bodies, as `morph transfer` carries it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from morph.extras import require

if TYPE_CHECKING:
    from morph.policy_transfer.relay_record import RelayRecord


def transfer(
    policy: str | Path,
    chain: Sequence[str | Path],
    out: str | Path,
    *,
    task: str = "balance",
    samples: int | Sequence[int] = 60,
    trials: int = 20,
    repeats: int = 5,
    scratch: int = 12,
    seed: int = 0,
    fresh: bool = False,
) -> RelayRecord:
    """Return what became of a policy that is carried along a chain of bodies.

    A map is learned at each hop. The same call again goes on at the hop where it was interrupted.

    Args:
        policy: Folder of the first body's policy; or `learned`: it is learned first.
        chain: The bodies in order, as `morph.load` takes them.
        out: Folder for the policy, the maps and a report.
        task: What all of them do.
        samples: Transitions of each hop's target: one number, or one for each hop.
        trials: Runs over which a policy is judged.
        repeats: How often each point of a learning curve is drawn; 0: there are no curves.
        scratch: Rounds of 8 runs in which each target is also learned from scratch.
        seed: Random seed.
        fresh: Begin anew in a folder that holds an earlier transfer.

    Raises:
        MorphError: An input cannot be used, or a result cannot be written.
        AlignError: No map of the first hop can be learned.
    """
    require("learn", "morph.transfer")
    from morph.app.cli.align_arguments import Transfer
    from morph.app.cli.transfer import transferred

    return transferred(
        Transfer(
            policy=str(policy),
            chain=tuple(str(body) for body in chain),
            out=str(out),
            task=task,
            samples=(samples,) if isinstance(samples, int) else tuple(samples),
            trials=trials,
            repeats=repeats,
            scratch=scratch,
            seed=seed,
            fresh=fresh,
            quiet=True,
        )
    )
