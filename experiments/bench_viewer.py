"""The viewer in figures: how soon, how fluent, how heavy.

Each figure stands beside its goal and a control. Seconds count from the command; the browser is
a headless Chromium that runs already and draws by the processor, on the cores that the viewer
runs on too. `opens` is the longest part.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from rich.console import Console
from rich.table import Table

from experiments.viewed.browser import browsing
from experiments.viewed.opening import framed, held, held_by_nothing, sent
from morph.arrays import JSON
from morph.body.shelf import names
from morph.errors import MorphError

EXAMPLE = """example:
  python -m experiments.bench_viewer
  python -m experiments.bench_viewer --only sent frame --quick
  python -m experiments.bench_viewer --json > out/viewer.json"""

PAIRS = (
    "pendulum humanoid",
    "quadruped_printed so101",
    "humanoid humanoid_skateboard",
)
"""Two bodies at once: of very different sizes, with meshes, and the two with most shapes."""

ALL = (
    "cartpole rider_rigid_driven hopper biped humanoid quadruped_printed hexapod_swimmer sea_snake"
)
"""As many as there is room for."""

SENT, FRAME, MEMORY = 5.0, 15.0, 300.0
"""Goals: s, s, MB."""


@dataclass(frozen=True, kw_only=True)
class Row:
    """One figure."""

    what: str
    """What was measured."""
    figure: str
    """What came out."""
    goal: str = ""
    """What was hoped for; empty for a control."""
    holds: bool | None = None
    """Whether it holds; None for a control."""


@dataclass(frozen=True, kw_only=True)
class Part:
    """What one part found."""

    rows: tuple[Row, ...]
    """For the table."""
    found: JSON
    """All of it."""


def bodies(quick: bool) -> tuple[str, ...]:
    """Return what is opened: each body of the shelf alone, pairs, and eight at once."""
    return ("pendulum", "cartpole pendulum") if quick else (*names(), *PAIRS, ALL)


def _told(words: str, text: str) -> None:
    sys.stderr.write(f"  {words}: {text}\n")
    sys.stderr.flush()


def _sent(quick: bool) -> Part:
    found = []
    for words in bodies(quick):
        found.append(sent(words))
        _told(words, f"sent after {found[-1]['sent_s']:.2f} s, {found[-1]['sent_mb']:.2f} MB")
    return Part(rows=(_worst("scene sent", found, "sent_s", SENT),), found=found)


def _frame(quick: bool) -> Part:
    found = []
    with browsing() as browser:
        for words in bodies(quick):
            found.append(framed(browser, words))
            _told(words, f"first frame after {found[-1]['frame_s']:.1f} s")
    return Part(rows=(_worst("first frame", found, "frame_s", FRAME),), found=found)


def _worst(what: str, found: Sequence[JSON], key: str, goal: float) -> Row:
    seconds = sorted(each[key] for each in found)
    worst = max(found, key=lambda each: each[key])
    return Row(
        what=f"{what}, {len(found)} openings of the shelf: median, worst",
        figure=f"{seconds[len(seconds) // 2]:.1f}, {worst[key]:.1f} s ({worst['words']})",
        goal=f"{goal:g} s",
        holds=worst[key] <= goal,
    )


def _memory(quick: bool) -> Part:
    with browsing() as browser:
        nothing = held_by_nothing(browser)
        found = [held(browser, words) for words in (("cartpole pendulum",) if quick else PAIRS)]
    rows = [
        Row(
            what=f"memory, {each['words']}: server (at most), page",
            figure=f"{each['server_mb']:.0f} ({each['server_peak_mb']:.0f}), "
            f"{each['page_mb']:.0f} MB",
            goal=f"{MEMORY:g} MB together",
            holds=each["server_mb"] + each["page_mb"] <= MEMORY,
        )
        for each in found
    ]
    control = (
        f"{nothing['server_mb']:.0f} ({nothing['server_peak_mb']:.0f}), {nothing['page_mb']:.0f} MB"
    )
    rows.append(Row(what="control: viser alone, nothing to show", figure=control))
    return Part(rows=tuple(rows), found=[*found, nothing])


PARTS: dict[str, Callable[[bool], Part]] = {
    "sent": _sent,
    "frame": _frame,
    "memory": _memory,
}
"""Every part by its name."""


def report(parts: dict[str, Part]) -> None:
    """Print the figures beside their goals."""
    table = Table(title="The viewer")
    for title in ("measured", "figure", "goal", "holds"):
        table.add_column(title)
    for part in parts.values():
        for row in part.rows:
            holds = "" if row.holds is None else "yes" if row.holds else "no"
            table.add_row(row.what, row.figure, row.goal, holds)
    Console().print(table)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the benchmark and return its exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.bench_viewer",
        description=__doc__,
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--only", nargs="+", choices=tuple(PARTS), help="these parts alone")
    parser.add_argument("--quick", action="store_true", help="little of each: does it work at all")
    parser.add_argument("--json", action="store_true", help="print JSON instead of a table")
    asked = parser.parse_args(arguments)
    parts = {}
    try:
        for name in asked.only or PARTS:
            print(f"{name} ...", file=sys.stderr, flush=True)
            parts[name] = PARTS[name](asked.quick)
    except MorphError as error:
        print(error, file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130
    if asked.json:
        found = {name: part.found for name, part in parts.items()}
        print(json.dumps({"schema": "morph.bench_viewer/1", **found}, indent=1))
    else:
        report(parts)
    return 0


if __name__ == "__main__":
    sys.exit(main())
