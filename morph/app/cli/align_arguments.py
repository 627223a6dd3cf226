"""What the commands between two bodies take: `morph align` and `morph transfer`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from morph.app.cli.options import Name, unset


@dataclass(frozen=True, kw_only=True)
class Align:
    """Learn how a body's states and commands are another's, and show which part is which.

    What both did is made in their simulations, or read: --source and --target name NPZ files
    with the arrays state, command and after, of any laboratory's bodies.
    Exit status 3: the guard judges the map unsafe; what was found is written, and says so.

    Example: morph align cartpole rider_rigid_driven --out aligned
    """

    bodies: Annotated[tyro.conf.Positional[tuple[str, ...]], unset("A B")] = ()
    """The source and the target: two descriptions, robot folders or names on the shelf."""
    source: Annotated[Path | None, unset("FILE")] = None
    """What the source did, as NPZ, instead of a body."""
    target: Annotated[Path | None, unset("FILE")] = None
    """What the target did, as NPZ, instead of a body."""
    pairs: Annotated[Path | None, unset("FILE")] = None
    """States of both that correspond, as NPZ with source and target, for maps that need them."""
    map: Name = None
    """How the map is learned; by default the first that what is given allows."""
    task: Annotated[str, tyro.conf.arg(metavar="TASK")] = "balance"
    """What both bodies can be asked to do: it says where they rest."""
    samples: Annotated[int, tyro.conf.arg(metavar="N")] = 60
    """Transitions of the target that it is learned from; 100 more are made to judge it by."""
    out: Annotated[str | None, unset("DIR")] = None
    """Folder for align.json, report.html and the map; without one nothing is written."""
    seed: int = 0
    """Random seed."""
    fresh: bool = False
    """Replace what an earlier alignment left in the folder."""
    json: bool = False
    """Print align.json instead of words."""
    quiet: bool = False
    """Show no progress."""


@dataclass(frozen=True, kw_only=True)
class Transfer:
    """Carry a policy along a chain of bodies, over a map that is learned at each hop.

    The same command again goes on at the hop it was in. Exit status 3: the guard judges a hop
    unsafe; the policy is written, and says so.

    Example: morph transfer --from learned --chain cartpole rider_rigid_driven --out carried
    """

    policy: Annotated[str, tyro.conf.arg(name="from", metavar="POLICY")]
    """Folder of the first body's policy; or `learned`: it is learned first."""
    chain: Annotated[tuple[str, ...], tyro.conf.arg(metavar="A B ...")]
    """The bodies in order: descriptions, robot folders or names on the shelf."""
    out: Annotated[str, tyro.conf.arg(metavar="DIR")]
    """Folder for transfer.json, report.html, the policy and the maps."""
    task: Annotated[str, tyro.conf.arg(metavar="TASK")] = "balance"
    """What all of them do."""
    over: Annotated[tuple[str, ...], unset("BODY ...")] = ()
    """Bodies that the way between the two of --chain may go over; those are taken, and in that
    order, over which the worst hop promises most by their descriptions."""
    samples: Annotated[tuple[int, ...], tyro.conf.arg(metavar="N ...")] = (60,)
    """Transitions of the target of each hop: one number for all, or one for each."""
    noise: Annotated[float, tyro.conf.arg(metavar="SIGMA")] = 0.001
    """Standard deviation of every reading: 0.001 is that of a fair encoder; at 0.01, the noise of
    the tasks, 60 transitions tell little of a body of many joints."""
    trials: Annotated[int, tyro.conf.arg(metavar="N")] = 20
    """Runs over which a policy is judged."""
    repeats: Annotated[int, tyro.conf.arg(metavar="N")] = 5
    """How often each point of a learning curve is drawn anew; 0: there are no curves."""
    scratch: Annotated[int, tyro.conf.arg(metavar="N")] = 12
    """Rounds of 8 runs in which each target is also learned from scratch; 0: it is not."""
    seed: int = 0
    """Random seed."""
    fresh: bool = False
    """Begin anew in a folder that holds an earlier transfer."""
    json: bool = False
    """Print transfer.json instead of words."""
    quiet: bool = False
    """Show no progress."""
