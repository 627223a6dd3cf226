"""The chain of `morph transfer --over`: chosen by what hops promise."""

from __future__ import annotations

import sys
from dataclasses import replace
from typing import TYPE_CHECKING

from morph.app.cli.align_arguments import Transfer
from morph.app.cli.console import harmless
from morph.errors import TransferError

if TYPE_CHECKING:
    from morph.policy_transfer.body import Body

MOST_OVER = 12
"""Most bodies that a way may be chosen from: every pair of them is looked at."""


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
