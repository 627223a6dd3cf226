"""What `morph transfer` is asked: counts within their limits, and a chain, given or chosen."""

from __future__ import annotations

import sys
from dataclasses import replace
from typing import TYPE_CHECKING

from morph.app.cli.align_arguments import Transfer
from morph.app.cli.console import harmless
from morph.errors import TransferError

if TYPE_CHECKING:
    from morph.policy_transfer.body import Body

FEWEST, MOST = 10, 100_000
"""Transitions of a hop, at least and at most."""

MOST_NOISE = 0.1
"""Most noise of a reading, in its unit."""

MOST_OVER = 12
"""Most bodies that a way may be chosen from: every pair of them is looked at."""


def check_numbers(options: Transfer) -> None:
    """Refuse counts that no transfer can have.

    Raises:
        TransferError: One is too small or too large.
    """
    hops = len(options.chain) - 1
    wrong = [
        (hops < 1, "--chain", f"{len(options.chain)} bodies make no hop", "name two or more"),
        (
            len(options.samples) not in {1, max(hops, 1)},
            "--samples",
            f"{len(options.samples)} numbers are given for {hops} hops",
            "give one for all hops, or one for each",
        ),
        (
            min(options.samples, default=0) < FEWEST,
            "--samples",
            f"{min(options.samples, default=0)} transitions tell nothing of a body",
            f"give {FEWEST} or more",
        ),
        (
            max(options.samples, default=0) > MOST,
            "--samples",
            f"{max(options.samples, default=0)} transitions would take longer than anyone waits",
            f"give {MOST} or fewer; some hundreds tell all that there is",
        ),
        (
            not 0.0 <= options.noise <= MOST_NOISE,
            "--noise",
            f"{options.noise:g} is no noise that a body could be seen through",
            f"give 0 to {MOST_NOISE:g}",
        ),
        (options.trials < 1, "--trials", f"{options.trials} runs judge nothing", "give 1 or more"),
        (options.repeats < 0, "--repeats", f"{options.repeats} is no count", "give 0 or more"),
        (options.scratch < 0, "--scratch", f"{options.scratch} is no count", "give 0 or more"),
        (options.seed < 0, "--seed", f"{options.seed} is no seed", "give 0 or more"),
    ]
    for holds, where, what, fix in wrong:
        if holds:
            raise TransferError(what, where=where, fix=fix)


def check_over(options: Transfer) -> None:
    """Refuse a choice of ways that cannot be made.

    Raises:
        TransferError: There are not two ends, too many bodies, or a count for each hop.
    """
    for holds, what, fix in (
        (
            len(options.chain) != 2,
            f"--chain names {len(options.chain)} bodies, and the way between is to be chosen",
            "name the two ends alone",
        ),
        (
            len(options.samples) != 1,
            "--samples gives a number for each hop of a way that is not chosen yet",
            "give one number for all hops",
        ),
        (
            len(options.over) > MOST_OVER,
            f"{len(options.over)} bodies are too many to choose from",
            f"name at most {MOST_OVER}",
        ),
    ):
        if options.over and holds:
            raise TransferError(what, where="--over", fix=fix)


def chosen_way(options: Transfer) -> tuple[Transfer, list[Body]]:
    """Return what was asked with its chain chosen, and the bodies of the chain.

    Raises:
        MorphError: A body cannot be used.
    """
    from morph.app.cli.transfer_bodies import body_of
    from morph.policy_transfer.path import path

    first, last = options.chain
    names = (first, *options.over, last)
    bodies = [body_of(name, options.task) for name in names]
    way = path(bodies, most=len(bodies) - 1, seed=options.seed)
    places = [next(at for at, body in enumerate(bodies) if body is each) for each in way]
    chain = tuple(names[at] for at in places)
    if not options.quiet:
        sys.stderr.write(f"the way that promises most: {harmless(' > '.join(chain))}\n")
    return replace(options, chain=chain, over=()), list(way)
