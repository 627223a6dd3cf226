from __future__ import annotations

import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest
import trimesh

from morph.print.assembly import steps
from morph.print.explode import exploded
from morph.print.job import Job, Laid, Orientation, Plate
from morph.print.mesh import Mesh
from morph.print.part import Hinge, Part, Placement, Seat
from morph.print.printer import Profile, material, printer
from morph.print.sheet import sheet
from morph.print.sliced import Sliced
from morph.print.weight import box

EVIL = '<script>alert("x")</script>&'


def block(*size: float) -> Mesh:
    solid = trimesh.creation.box(size)
    return Mesh(vertices=np.array(solid.vertices), faces=np.array(solid.faces, dtype=np.int64))


def part(name: str, links: dict[str, float], mesh: Mesh, **more: object) -> Part:
    placements = []
    for link, y in links.items():
        world = np.eye(4)
        world[1, 3] = y
        placements.append(Placement(link=link, pose=np.eye(4), world=world))
    return Part(
        **({"kind": "printed", "name": name, "mesh": mesh, "placements": tuple(placements)} | more)  # type: ignore[arg-type]
    )


def seat(holds: str) -> Seat:
    return Seat(holds=holds, position=np.zeros(3), axis=np.array([0.0, 0.0, 1.0]), bore_mm=2.0)


PARTS = (
    part(
        "trunk",
        {"trunk": 0.0},
        block(40, 20, 8),
        number="P-01",
        seats=(seat("SG90"), seat("M2"), seat("M2")),
    ),
    part("leg", {"left_leg": 30.0, "right_leg": -30.0}, block(6, 6, 50), number="P-02"),
    part("sg90", {"trunk": 0.0}, block(12, 8, 20), number="B-01", kind="bought"),
    part("four_cells", {"trunk": 0.0}, block(30, 10, 5), number="B-02", kind="bought"),
)
HINGES = tuple(
    Hinge(
        name=f"{side}_hip",
        kind="hinge",
        position=np.zeros(3),
        axis=np.array([0.0, 1.0, 0.0]),
        low=-1.0,
        high=1.0,
        still="trunk",
        moving=f"{side}_leg",
    )
    for side in ("left", "right")
)


@pytest.fixture
def job() -> Job:
    lies = Orientation(turn=np.eye(3), support_mm3=0.0, first_support_mm3=2500.0, height_mm=8.0)
    printed = [each for each in PARTS if each.kind == "printed"]
    laid = tuple(
        Laid(part=each.name, copy=copy, pose=np.eye(4))
        for each in printed
        for copy in range(each.count)
    )
    return Job(
        profile=Profile(printer=printer("mk4"), material=material("pla")),
        parts=PARTS,
        refused=(),
        checks=(),
        orientations={each.name: lies for each in printed},
        sliced={
            each.name: Sliced(
                source="estimate", weight=box(0.0105, np.ones(3)), support_kg=0.0, seconds=1800.0
            )
            for each in printed
        },
        plates=(Plate(name="plate_1", laid=laid),),
    )


class Text(HTMLParser):
    """The texts of a page, by the element that they stand in."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.found: list[str] = []
        self.tags: list[str] = []
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: object) -> None:
        self.tags.append(tag)

    def handle_data(self, data: str) -> None:
        self.found.append(data.strip())


def test_the_table_counts_weighs_and_says_where_and_how(job: Job) -> None:
    text = " | ".join(filter(None, Text(sheet(job, HINGES, title="Walker")).found))
    # Three copies of 10.5 g and half an hour each.
    assert "3 printed parts of 2 sorts on 1 plate: 32 g, about 1 h 30 min." in text
    assert "P-02 | leg | either | 2 | plate 1 | 10.5" in text
    assert "no support (as drawn: 2.5 cm³), 8 mm high" in text
    assert "B-01 | sg90 | 1" in text


def test_steps_fill_a_link_before_others_are_put_onto_it(job: Job) -> None:
    made, joined = steps(job.parts, HINGES, exploded(job.parts, HINGES))
    assert made.links == ("trunk",)
    assert made.said == (
        "P-01 (trunk) holds SG90, 2 × M2.",
        "In it go, where there is room for them: four cells.",
    )
    # Two legs that are alike are one step, done twice.
    assert joined.links == ("left_leg", "right_leg")
    assert "joint left hip" in joined.said[1]


def test_joints_that_are_like_no_other_share_a_step_and_servos_are_centred_once() -> None:
    chain = [part(name, {name: 30.0 * at}, block(6, 6, 6)) for at, name in enumerate("abcd")]
    hinges = [
        replace(HINGES[0], name=f"{still}{moving}", still=still, moving=moving)
        for still, moving in ("ab", "bc", "cd")
    ]
    (joined,) = steps(chain, hinges, exploded(chain, hinges))
    assert joined.links == ("b", "c", "d")
    assert len(joined.said) == 4


def test_pieces_of_a_part_are_put_together_first(job: Job) -> None:
    halves = tuple(
        replace(PARTS[0], name=f"trunk_{side}", piece_of="trunk", seats=()) for side in "ab"
    )
    made, *_ = steps((*halves, PARTS[1]), HINGES, exploded((*halves, PARTS[1]), HINGES))
    assert made.needs == ((1, "P-01", "trunk_a"), (1, "P-01", "trunk_b"))
    assert "go together one way only" in made.said[0]


def test_gauges_come_first_if_there_are_any(job: Job) -> None:
    gauge = part("gauge_sg90", {}, block(30, 20, 5), number="G-01")
    tried = replace(
        job,
        gauges=(gauge,),
        orientations={**job.orientations, gauge.name: job.orientations["leg"]},
    )
    titles = re.findall(r"<h3>(.*?)</h3>", sheet(tried, HINGES, title="Walker"))
    assert titles[0] == "Print the gauges first"
    assert "Print the gauges first" not in sheet(job, HINGES, title="Walker")


def test_no_text_from_a_file_becomes_html(job: Job) -> None:
    plain = Text(sheet(job, HINGES, title="Walker", command="morph print walker"))
    evil = replace(
        job,
        parts=(replace(PARTS[0], name=EVIL, number=EVIL, seats=(seat(EVIL),)), *PARTS[1:]),
        refused=(replace(PARTS[1], name=EVIL),),
        notes=(EVIL,),
    )
    hinges = tuple(replace(each, name=EVIL) for each in HINGES)
    page = sheet(evil, hinges, title=EVIL, command=EVIL)
    assert "<script" not in page
    assert "script" not in Text(page).tags
    assert "script" not in plain.tags


def test_the_page_asks_for_nothing_and_is_light(job: Job) -> None:
    page = sheet(job, HINGES, title="Walker")
    assert "default-src 'none'" in page
    assert re.findall(r'(?:src|href)="', page) == []
    assert len(page) < 60_000


def test_a_job_of_which_all_is_refused_still_has_a_sheet(job: Job) -> None:
    none = replace(job, parts=(), refused=PARTS, orientations={}, sliced={}, plates=())
    assert "Not everything can be printed" in sheet(none, HINGES, title="Walker")
