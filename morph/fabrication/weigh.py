"""A package corrected by a scale: its robot weighs what was read, and its policy is tried again."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from morph.body.load import load
from morph.body.robot import Robot
from morph.errors import MakeError, OutputError
from morph.fabrication.content import Package
from morph.fabrication.link_mass import LinkMass
from morph.fabrication.masses import link_masses
from morph.fabrication.package import DESIGNED, ROBOT, write_content, write_printed
from morph.fabrication.package_folder import CONTENT
from morph.fabrication.packed import FILE
from morph.fabrication.policies import matched_again
from morph.fabrication.reading import read_packed
from morph.fabrication.rematch import Matched


@dataclass(frozen=True, kw_only=True, eq=False)
class Weighed:
    """What readings came to."""

    package: Package
    """The package as it is now."""
    before_kg: float
    """What the robot weighed before these readings, kg."""
    designed: Robot
    """The robot as designed."""
    printed: Robot
    """The robot as it is now."""
    matched: Matched | None = None
    """What became of the policy; None if there is none, or nothing had changed."""


def weighed(package: Package, designed: Robot, readings: Mapping[str, float]) -> Package:
    """Return a package whose links weigh what a scale showed.

    A part's spread is that which was predicted, of another density; its links are put together
    anew from all their parts.

    Args:
        package: The package.
        designed: The robot as designed.
        readings: What one copy weighs, kg, by the part's name; parts that are not named weigh
            what was predicted.
    """
    links = link_masses(designed, package.job, package.complete, readings)
    return replace(package, links=links, readings=dict(readings))


def write_weighed(
    source: Path,
    folder: Path,
    package: Package,
    readings: Mapping[str, float],
    *,
    seconds: float,
    seed: int = 0,
    progress: Callable[[str], None] = lambda _: None,
) -> Weighed:
    """Write a corrected copy of a package, but for its report.

    The policy is tried on the corrected robot, and matched again if it is lost. A robot that
    weighs what it weighed before keeps its policy, and what was said of it, unless it is lost.

    Args:
        source: The package as it is.
        folder: An empty folder that is to become the package.
        package: What `source` holds.
        readings: What one copy weighs, kg, by the part's name: all readings there are.
        seconds: How long matching may take, s; 0 to say only whether the policy holds.
        seed: Chance begins from it.
        progress: Is told what is going on.

    Raises:
        MorphError: The package cannot be used or written.
    """
    progress("correcting the robot")
    content = read_packed(source / FILE)
    designed = _designed(source, package)
    after = weighed(package, designed, readings)
    same, result = _alike(package.links, after.links), None
    _copy(source, folder, but=() if same else (ROBOT,))
    printed = load(folder / ROBOT) if same else write_printed(folder / ROBOT, designed, after)
    after = replace(after, made_sha256=printed.sha256)
    if package.policy is not None and not (same and package.policy.verdict != "lost"):
        result, statement = matched_again(
            source, folder, seconds=seconds, seed=seed, progress=progress
        )
        after = replace(after, policy=statement)
    every = (*content.parts, *content.gauges)
    files = {each.name: each.file for each in every if each.file}
    files |= {each.name: each.file for each in content.plates}
    files |= {f"{each.name}.gcode": each.gcode for each in content.plates if each.gcode}
    write_content(folder, after, files)
    return Weighed(
        package=replace(after, folder=source),
        before_kg=package.now_kg,
        designed=designed,
        printed=printed,
        matched=result,
    )


def _designed(source: Path, package: Package) -> Robot:
    """Return the robot as designed, of whose links the package speaks."""
    robot = load(source / DESIGNED)
    names = [link.name for link in robot.links]
    given = [each.link for each in package.links]
    if names != given:
        raise MakeError(
            f"the links of {DESIGNED} are {', '.join(names)[:200]}, and the package speaks of "
            f"{', '.join(given)[:200]}",
            where=str(source),
            fix="make the package anew with `morph print`",
        )
    return robot


def _alike(one: Sequence[LinkMass], other: Sequence[LinkMass]) -> bool:
    """Return whether every link weighs the same, number for number, and from the same source."""
    return all(
        a.source == b.source
        and a.now.mass == b.now.mass
        and np.array_equal(a.now.com, b.now.com)
        and np.array_equal(a.now.inertia, b.now.inertia)
        for a, b in zip(one, other, strict=True)
    )


def _copy(source: Path, folder: Path, *, but: Sequence[str]) -> None:
    """Copy what a package holds, but for some of it."""
    try:
        for each in sorted(source.iterdir()):
            if each.name not in CONTENT or each.name in but or each.is_symlink():
                continue
            if each.is_dir():
                shutil.copytree(each, folder / each.name, symlinks=True)
            else:
                shutil.copy2(each, folder / each.name)
    except OSError as error:
        raise OutputError(
            f"cannot be copied: {error.strerror or error}",
            where=str(source),
            fix="make room on the disk, or make the package anew with `morph print`",
        ) from error
