from __future__ import annotations

from dataclasses import replace
from functools import cache
from html.parser import HTMLParser

import manifold3d
import numpy as np
import pytest

from morph.app.report.print.page import print_page
from morph.app.report.print.steps import advised, steps
from morph.app.report.print.words import summary
from morph.body.load import load
from morph.fabrication.content import Package
from morph.fabrication.masses import link_masses
from morph.print.job import Job
from morph.print.mesh import from_manifold
from morph.print.part import Check, Part, Placement
from morph.print.prepare import prepare
from morph.print.printer import Profile, material, printer

HOSTILE = "<script>alert(1)</script>\"'&{{7*7}}"


@cache
def job() -> Job:
    link = load("pendulum").links[-1].name
    bar = Part(
        name="bar",
        number="P-01",
        kind="printed",
        mesh=from_manifold(manifold3d.Manifold.cube((20, 20, 40), True)),
        placements=(Placement(link=link, pose=np.eye(4), world=np.eye(4)),) * 2,
    )
    profile = Profile(printer=printer("mk4"), material=material("pla"))
    return prepare([bar], [], profile, slicer=None)


def package(job: Job, *complete: str) -> Package:
    robot = load("pendulum")
    return Package(
        name=robot.name,
        title=robot.name,
        designed_sha256=robot.sha256,
        job=job,
        links=link_masses(robot, job, complete),
    )


@pytest.fixture(autouse=True)
def _without_solids(monkeypatch: pytest.MonkeyPatch) -> None:
    # Half of the page's megabytes draw the body; another test has them.
    monkeypatch.setattr("morph.app.report.print.page.solids", lambda package: [])


class Tags(HTMLParser):
    """The tags of a page."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.seen: list[str] = []
        self.text: list[str] = []
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: object) -> None:
        self.seen.append(tag)

    def handle_data(self, data: str) -> None:
        self.text.append(data)


def test_names_from_files_are_text_wherever_they_stand() -> None:
    made = job()
    refused = replace(made.parts[0], name=HOSTILE)
    checks = tuple(
        Check(part=HOSTILE, name=HOSTILE, verdict=verdict, what=HOSTILE, fix=HOSTILE)
        for verdict in ("refused", "noted", "passed")
    )
    hostile = replace(
        package(replace(made, refused=(refused,), checks=checks, notes=(HOSTILE,))),
        name=HOSTILE,
        title=HOSTILE,
        notes=(HOSTILE,),
        command=HOSTILE,
        links=tuple(replace(each, link=HOSTILE) for each in package(made).links),
    )
    page = print_page(hostile)
    tags = Tags(page)
    assert "script" not in tags.seen
    assert "alert(1)</script>" not in page
    assert "49" not in "".join(text for text in tags.text if "alert" in text)
    assert sum(HOSTILE in text for text in tags.text) > 5


def test_the_steps_say_what_to_do_with_what_is_there() -> None:
    said = [step.what for step in steps(package(job()))]
    assert said == [
        "Print 1 plate",
        "Buy the rest and put it together",
        "Weigh what came off the printer",
        "Learn and simulate on the robot in robot/, not on the model",
    ]
    (printing, *_) = steps(package(job()))
    assert "layers of 0.2 mm, 2 walls, 15 % infill" in printing.how
    (printing, *_) = steps(package(job()), {"plate_1"})
    assert printing.how.startswith("Their G-code lies beside them.")


def test_where_nothing_can_be_printed_nothing_is_to_be_printed() -> None:
    made = job()
    check = Check(part="bar", name="wall", verdict="refused", what="thin", fix="thicken it")
    none = Job(
        profile=made.profile,
        parts=(),
        refused=made.parts,
        checks=(check,),
        plates=(),
        sliced={},
        orientations={},
    )
    said = steps(package(none))
    assert said[0].what == "Mend 1 thing and make the package anew"
    assert "Before that, nothing can be printed." in said[0].how
    assert len(said) == 2


def test_what_asks_for_the_same_stands_together_and_nothing_is_lost() -> None:
    checks = [
        Check(part=str(at), name="closed", verdict="refused", what="open", fix=fix)
        for at, fix in enumerate(("close it", "split it", "close it"))
    ]
    found = advised(checks)
    assert [(each.fix, [check.part for check in each.checks]) for each in found] == [
        ("close it", ["0", "2"]),
        ("split it", ["1"]),
    ]


def test_the_summary_says_whose_masses_they_are() -> None:
    described = " ".join(summary(package(job())))
    assert "of none of its links all that it weighs is known" in described
    every = [link.name for link in load("pendulum").links]
    known = " ".join(summary(package(job(), *every)))
    assert "with what its parts weigh it is" in known
    assert "keep what was described" not in known
