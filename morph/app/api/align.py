"""A map between two bodies, as `morph align` learns it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from morph.extras import require

if TYPE_CHECKING:
    from morph.app.report.align.outcome import Aligned


def align(
    source: str | Path,
    target: str | Path,
    *,
    map: str | None = None,
    task: str = "balance",
    samples: int = 60,
    seed: int = 0,
    out: str | Path | None = None,
) -> Aligned:
    """Return how one body's states and commands are another's, with the guard's verdict.

    Args:
        source: The body that is known, as `morph.load` takes it; or what it did, as the path of
            an `.npz` with state, command and after.
        target: The other.
        map: How the map is learned; by default the first of `docs/maps.md` that the data allow.
        task: What both can be asked to do: it says where they rest.
        samples: Transitions of the target that it is learned from.
        seed: Random seed.
        out: Folder for the map and a report; by default nothing is written.

    Raises:
        MorphError: An input cannot be used.
        AlignError: No map can be learned.
    """
    require("learn", "morph.align")
    from morph.app.cli.align import aligned
    from morph.app.cli.align_arguments import Align

    files = [Path(each) if str(each).endswith(".npz") else None for each in (source, target)]
    sides = zip((source, target), files, strict=True)
    return aligned(
        Align(
            bodies=tuple(str(body) for body, file in sides if file is None),
            source=files[0],
            target=files[1],
            map=map,
            task=task,
            samples=samples,
            seed=seed,
            out=None if out is None else str(out),
            quiet=True,
        )
    )
