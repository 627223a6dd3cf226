"""Types of options that several commands take, and how `--help` shows them."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

import tyro


def unset(metavar: str) -> Any:
    """Return how an option is shown that is not given by default: without a default.

    Args:
        metavar: What stands for its value.
    """
    return tyro.conf.arg(metavar=metavar, help_behavior_hint="")


Many = tyro.conf.UseAppendAction[tuple[str, ...]]
"""An option that may be repeated, one value each time."""
File = Annotated[str | None, unset("FILE")]
"""A file."""
Folder = Annotated[Path | None, unset("DIR")]
"""A folder."""
Name = Annotated[str | None, unset("NAME")]
"""A name."""
Names = Annotated[tuple[str, ...], unset("NAME ...")]
"""Several names."""
Seconds = Annotated[float | None, unset("SECONDS")]
"""A time."""
Horizon = Annotated[str, tyro.conf.arg(metavar="SECONDS|full")]
"""How long rollouts are."""
Posture = Annotated[str | None, unset("NAME|FILE")]
"""Where a robot starts."""
Base = Annotated[Literal["fixed", "floating", "board"] | None, unset("{fixed,floating,board}")]
"""How a robot stands in the world."""


def description_options(base: str | None, folder: Path | None) -> list[str]:
    """Return the options under which a description is read, as they are typed."""
    given = [] if base is None else ["--base", base]
    return given if folder is None else [*given, "--folder", str(folder)]
