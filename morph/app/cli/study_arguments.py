"""What `morph study` takes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import tyro

from morph.app.cli.options import Folder, Many, unset


@dataclass(frozen=True, kw_only=True)
class Study:
    """Run many independent cells of a study, each result saved as soon as it is there.

    A killed worker's cells are run again; what kills its worker twice is put in quarantine.
    With --resume the same command goes on where it was interrupted. Exit status 3: cells failed,
    or --against found a difference.

    Example: morph study swing.toml --workers 2 --out swing
    """

    file: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="FILE")]
    """TOML with a function and its cases (docs/study.md)."""
    out: Annotated[str | None, unset("DIR")] = None
    """Folder for study.json, cells/ and rows.json; by default out/NAME of the study."""
    engine: Literal["local", "dask", "slurm", "submitit-local", "inline"] = "local"
    """Engine that runs the cells: processes, a Dask scheduler's workers, Slurm, the same jobs on
    this machine, or inline: this process, for a debugger."""
    workers: int = 2
    """Processes, or jobs at once; ignored with --scheduler."""
    scheduler: Annotated[str | None, unset("ADDRESS")] = None
    """Dask scheduler, tcp://host:8786; without one Dask runs on this machine."""
    job: Annotated[Many, unset("NAME=VALUE")] = ()
    """What a Slurm job asks for: timeout_min=60, mem_gb=4, slurm_partition=long; repeatable."""
    resume: bool = False
    """Go on with what --out holds; what failed is run again."""
    fresh: bool = False
    """Begin anew in a folder that holds results, which are deleted."""
    stale: Literal["refuse", "rerun", "keep"] = "refuse"
    """With --resume: what becomes of results of other code; kept ones are marked."""
    against: Folder = None
    """Compare the rows with those of another run, row by row."""
    ignore: Annotated[Many, unset("ENTRY")] = ()
    """With --against: an entry of a row that may differ, such as seconds; may be repeated."""
    json: bool = False
    """Print rows.json, or with --against the comparison, instead of the summary."""
    quiet: bool = False
    """Show no progress."""
