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
from dataclasses import asdict, dataclass
from typing import Any

from rich.console import Console
from rich.table import Table

from experiments.figures.result_file import figure_name
from experiments.figures.save_options import parse_and_save
from experiments.viewed.browser import browsing
from experiments.viewed.leaks import leaked
from experiments.viewed.opening import framed, held, held_by_nothing, sent
from experiments.viewed.raw import raw_speed
from experiments.viewed.size import empty_export, exported
from experiments.viewed.speed import speed
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

TASK = "cartpole rider_rigid_driven cart_two_links --task balance"
"""A comparison with arrows, charts and tables that change."""

SENT, FRAME, MEMORY, SIZE = 5.0, 15.0, 300.0, 5.0
"""Goals: s, s, MB, MB."""

SPEEDS = (
    (60, 1, False, 55.0),
    (200, 1, False, 30.0),
    (60, 2, True, None),
)
"""Links, bodies, whether all else is drawn too, and the goal in updates a second."""

RAW = (60, 200)
"""Links that viser alone moves, as a control."""

OPENS = 100
"""People who come and go."""

LEAK = 0.05
"""MB a page: 5 MB after a hundred, which is below what memory varies by."""


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
    found: JSON | list[JSON]
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


def _updates(quick: bool) -> Part:
    found, rows = [], []
    with browsing() as browser:
        for links, bodies, busy, goal in SPEEDS[: 1 if quick else None]:
            each = speed(browser, links, bodies=bodies, busy=busy)
            found.append(each)
            what = f"{links} moving links" + (", arrows, lines and heat" if busy else "")
            _told(what, f"{each['sent_hz']:.1f} updates/s")
            rows.append(
                Row(
                    what=f"{what}: updates/s sent, shown by the page; share of a core",
                    figure=f"{each['sent_hz']:.1f}, {each['reached_hz']:.1f}; "
                    f"{each['process_share']:.2f}",
                    goal="" if goal is None else f"{goal:g}/s",
                    # What a page draws of it is the business of its graphics card.
                    holds=None if goal is None else each["sent_hz"] >= goal,
                )
            )
        raw = [raw_speed(browser, links) for links in RAW[: 1 if quick else None]]
    rows += [
        Row(
            what=f"control: viser alone, {each['links']} links: sent, shown by the page",
            figure=f"{each['sent_hz']:.1f}, {each['reached_hz']:.1f}",
        )
        for each in raw
    ]
    return Part(rows=tuple(rows), found=[*found, *raw])


def _size(quick: bool) -> Part:
    found = []
    for words in ("cartpole pendulum",) if quick else (*PAIRS, ALL, TASK):
        found.append(exported(words))
        _told(words, f"{found[-1]['mb']:.2f} MB")
    worst = max(found, key=lambda each: each["mb"])
    row = Row(
        what=f"exported page, {len(found)} comparisons: greatest",
        figure=f"{worst['mb']:.1f} MB ({worst['words']})",
        goal=f"{SIZE:g} MB",
        holds=worst["mb"] <= SIZE,
    )
    empty = 1e-6 * empty_export()
    control = Row(
        what="control: viser alone, an exported page of nothing", figure=f"{empty:.1f} MB"
    )
    return Part(rows=(row, control), found=[*found, {"words": "viser alone", "mb": empty}])


def _opens(quick: bool) -> Part:
    with browsing() as browser:
        found = leaked(browser, 6 if quick else OPENS)
    people, control = found["people_mb"], found["control_mb"]
    rows = (
        Row(
            what=f"{found['times']} pages opened and closed: after the first, after the last; "
            "growth a page over the second half; threads before, after",
            figure=f"{people[0]:.0f}, {people[-1]:.0f} MB; "
            f"{1e3 * found['people_slope_mb']:.0f} kB; "
            f"{found['threads_before']}, {found['threads_after']}",
            goal=f"{1e3 * LEAK:.0f} kB a page above the control, no thread more",
            holds=found["people_slope_mb"] - found["control_slope_mb"] <= LEAK
            and found["threads_after"] <= found["threads_before"],
        ),
        Row(
            what="control: as many empty pages, nobody comes to the viewer",
            figure=f"{control[0]:.0f}, {control[-1]:.0f} MB; "
            f"{1e3 * found['control_slope_mb']:.0f} kB",
        ),
    )
    return Part(rows=rows, found=found)


PARTS: dict[str, Callable[[bool], Part]] = {
    "sent": _sent,
    "frame": _frame,
    "memory": _memory,
    "updates": _updates,
    "size": _size,
    "opens": _opens,
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


def headline(parts: dict[str, Part]) -> JSON:
    """Return what a result file holds: what each part measured, beside viser alone."""
    figures: JSON = {}
    for name, key in (("sent", "sent_s"), ("frame", "frame_s")):
        found: Any = parts[name].found if name in parts else []
        figures |= {f"{name}_worst_s": max(each[key] for each in found)} if found else {}
    every = [(name, row) for name, part in parts.items() for row in part.rows]
    controls = {}
    for _, row in every:
        if row.what.startswith("control: "):
            controls[row.what.removeprefix("control: ")] = {"figure": row.figure}
        else:
            figures[figure_name(row.what.partition(":")[0])] = row.figure
    rows = [{"part": name, **asdict(row)} for name, row in every]
    return {"figures": figures, "controls": controls, "rows": rows}


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
    asked, save = parse_and_save(parser, arguments, module="experiments.bench_viewer")
    parts = {}
    try:
        for name in asked.only or PARTS:
            print(f"{name} ...", file=sys.stderr, flush=True)
            parts[name] = PARTS[name](asked.quick)
    except MorphError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130
    if save:
        save(**headline(parts))
    if asked.json:
        found = {name: part.found for name, part in parts.items()}
        print(json.dumps({"schema": "morph.bench_viewer/1", **found}, indent=1))
    else:
        report(parts)
    return 0


if __name__ == "__main__":
    sys.exit(main())
