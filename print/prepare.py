"""From parts to a print job: looked at, cut to the bed, turned, weighed and laid on plates."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass, field, replace
from functools import partial
from threading import Event
from typing import TypeVar

from morph.print.clearance import clearances
from morph.print.errors import SplitError
from morph.print.estimate import estimated
from morph.print.gate import check_part
from morph.print.gauge import gauges
from morph.print.job import Job, Orientation, Plate
from morph.print.orient import orient
from morph.print.part import Check, Hinge, Part
from morph.print.plate import plates
from morph.print.printer import Profile
from morph.print.sliced import Sliced
from morph.print.slicer import Slicer
from morph.print.split import split

T = TypeVar("T")

AT_ONCE = 2
"""Slicers that run at the same time; each takes one core and some 200 MB."""


def prepare(
    parts: Sequence[Part],
    hinges: Sequence[Hinge],
    profile: Profile,
    *,
    slicer: Slicer | None,
    tell: Callable[[str], None] = lambda _: None,
    timeout_s: float = 300.0,
) -> Job:
    """Return the job of printing parts; what cannot be printed is in it as refused.

    Args:
        parts: Everything that the body is made of; what is not printed is passed on.
        hinges: How they move, to see whether they collide.
        profile: Printer, material and settings.
        slicer: The slicer to ask; None: masses are estimated.
        tell: Is told what is being done now.
        timeout_s: Longest that the slicer may take for one part, s.

    Raises:
        SlicerError: The slicer hung, died, or wrote what cannot be used.
        PlateError: What was accepted cannot be laid on plates.
    """
    gate = _Gate(profile=profile, tell=tell)
    for part in parts:
        gate.take(part)
    tell("turning joints to see whether parts collide")
    checks = (*gate.checks, *clearances((*gate.passed, *gate.kept), hinges, profile))
    tried = _tried(gate.passed, profile)
    turned = {}
    for part in (*gate.passed, *tried):
        tell(f"turning {part.name} to need little support")
        if part.mesh is not None:
            turned[part.name] = orient(part.mesh, profile)
    weighed = _weighed((*gate.passed, *tried), turned, profile, slicer, tell, timeout_s)
    tell("laying parts on plates")
    return Job(
        profile=profile,
        parts=(*(_with(part, weighed) for part in gate.passed), *gate.kept),
        refused=tuple(gate.refused),
        checks=checks,
        orientations=turned,
        sliced=weighed,
        plates=(
            *_named(plates(tried, turned, profile), "gauges"),
            *_named(plates(gate.passed, turned, profile), "plate"),
        ),
        gauges=tuple(_with(part, weighed) for part in tried),
        notes=_notes(slicer),
    )


@dataclass(kw_only=True)
class _Gate:
    """What is let through, and what was found."""

    profile: Profile
    tell: Callable[[str], None]
    passed: list[Part] = field(default_factory=list)
    kept: list[Part] = field(default_factory=list)
    refused: list[Part] = field(default_factory=list)
    checks: list[Check] = field(default_factory=list)

    def take(self, part: Part) -> None:
        if part.kind != "printed" or part.mesh is None:
            self.kept.append(part)
            return
        self.tell(f"looking at {part.name}")
        result, checks = check_part(part, self.profile)
        self.checks += checks
        if any(check.verdict == "refused" for check in checks):
            self.refused.append(part)
            return
        try:
            self.passed += split(result, self.profile)
        except SplitError as error:
            self.checks.append(
                Check(
                    part=part.name,
                    name="split",
                    verdict="refused",
                    what=error.what,
                    fix=error.fix,
                )
            )
            self.refused.append(part)


def _tried(parts: Sequence[Part], profile: Profile) -> tuple[Part, ...]:
    """Return the gauges; none for parts that hold nothing."""
    return tuple(part for part in gauges(parts, profile) if part.mesh is not None)


def _weighed(
    parts: Sequence[Part],
    turned: dict[str, Orientation],
    profile: Profile,
    slicer: Slicer | None,
    tell: Callable[[str], None],
    timeout_s: float,
) -> dict[str, Sliced]:
    if slicer is None:
        results = {}
        for part in parts:
            tell(f"estimating {part.name}")
            results[part.name] = estimated(part, turned[part.name], profile)
        return results

    mine = replace(slicer, stop=Event())

    def ask(part: Part) -> Sliced:
        tell(f"slicing {part.name}")
        return mine.sliced(part, turned[part.name], profile, timeout_s=timeout_s)

    return at_once({part.name: partial(ask, part) for part in parts}, mine)


def at_once(requested: Mapping[str, Callable[[], T]], slicer: Slicer) -> dict[str, T]:
    """Return what each call comes to, some at a time; after a failure the others are stopped.

    Args:
        requested: What to call, by its name.
        slicer: The slicer that they all ask; a failure, or Ctrl-C, stops it for good.
    """
    pool = ThreadPoolExecutor(AT_ONCE)
    try:
        begun = {name: pool.submit(call) for name, call in requested.items()}
        for future in as_completed(begun.values()):
            # The first that fails is told, not the first in order.
            future.result()
        return {name: future.result() for name, future in begun.items()}
    except BaseException:
        slicer.stop.set()
        raise
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def _with(part: Part, weighed: dict[str, Sliced]) -> Part:
    return replace(part, weight=weighed[part.name].weight)


def _named(laid: Iterable[Plate], name: str) -> Iterable[Plate]:
    return (replace(plate, name=f"{name}_{at}") for at, plate in enumerate(laid, start=1))


def _notes(slicer: Slicer | None) -> tuple[str, ...]:
    if slicer is not None:
        return ()
    return (
        "No slicer was asked: masses and times are estimates, and there is no G-code. "
        "Install PrusaSlicer for both.",
    )
