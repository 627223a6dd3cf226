"""Where the view's parts come from: a package, or a body that is divided on the spot."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from morph.body.load import load
from morph.body.robot import Robot
from morph.errors import MakeError, MorphError, ViewError
from morph.fabrication.content import Package
from morph.fabrication.divide import divide
from morph.fabrication.masses import link_masses
from morph.fabrication.package import ROBOT
from morph.fabrication.reading import read_package
from morph.print.errors import PrintError
from morph.print.prepare import prepare
from morph.print.printer import MATERIALS, PRINTERS, Profile


def packed(folder: Path) -> tuple[Robot, Package]:
    """Return the robot of a package, as it comes off the printer, and the package.

    Raises:
        MorphError: It cannot be read, or its robot is not the one that was written.
    """
    package = read_package(folder)
    robot = load(folder / ROBOT)
    if package.made_sha256 and robot.sha256 != package.made_sha256:
        raise ViewError(
            "the robot in the package is not the one that was written with it",
            where=str(folder / ROBOT),
            fix="make the package anew with `morph print`",
        )
    return replace(robot, name=package.name), package


def divided(robot: Robot) -> Package:
    """Return what `morph print` would make of a body, with masses estimated; it takes seconds.

    Raises:
        MorphError: It has no parts that could be made.
    """
    profile = Profile(printer=PRINTERS[0], material=MATERIALS[0])
    try:
        division = divide(robot, profile)
        job = prepare(division.parts, division.hinges, profile, slicer=None)
    except PrintError as error:
        raise MakeError(error.what, where=error.where, fix=error.fix) from error
    job = replace(job, checks=(*division.checks, *job.checks))
    return Package(
        name=robot.name,
        title=robot.card.title if robot.card is not None else robot.name,
        designed_sha256=robot.sha256,
        job=job,
        links=link_masses(robot, job, division.complete),
        hinges=division.hinges,
        complete=division.complete,
        notes=division.notes,
    )


def excuse(error: MorphError) -> str:
    """Return why nothing is printed, as a sentence."""
    return f"{error.where}: {error.what}. {error.fix}."
