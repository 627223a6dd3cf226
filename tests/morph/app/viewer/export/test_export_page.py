"""The exported page as text; that a browser plays it is shown in the browser's tests."""

from __future__ import annotations

import base64
import hashlib
import json
import threading
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest

from morph.app.viewer.camera import Camera
from morph.app.viewer.content import CellTable, Chart, ChartLine, Content, LiveCell, Moment
from morph.app.viewer.export.page import exported_page
from morph.app.viewer.export.recorded import FIGURES, recorded, rounded

EVIL = '<img src=x onerror="alert(1)"></script><script>alert(2)</script>'


class Read(HTMLParser):
    """Elements and scripts as a browser finds them."""

    def __init__(self, text: str) -> None:
        super().__init__(convert_charrefs=True)
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.scripts: list[str] = []
        self._within = ""
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        self._within = tag

    def handle_endtag(self, tag: str) -> None:
        self._within = ""

    def handle_data(self, data: str) -> None:
        if self._within == "script":
            self.scripts.append(data)

    def first(self, tag: str) -> dict[str, str | None]:
        return next(found for name, found in self.tags if name == tag)


@pytest.fixture(scope="module")
def full(shown: Content) -> Content:
    """The pendulum with all that can stand beside it, named by an enemy."""
    actor = shown.actors[0]
    count = actor.motion.pictures
    times = np.arange(count) / 60.0
    energy = np.linspace(0.0, 30.0, count)
    moves = replace(
        actor.motion, series={"energy": energy}, arrows={"contact": np.zeros((count, 1, 2, 3))}
    )
    figure = replace(actor.figure, robot=replace(actor.figure.robot, name=EVIL))
    return Content(
        actors=(replace(actor, motion=moves, figure=figure, title=EVIL),),
        charts=(
            Chart(title=EVIL, unit="J", lines=(ChartLine(name=EVIL, time=times, value=energy),)),
        ),
        tables=(
            CellTable(
                title=EVIL,
                head=(EVIL, "energy"),
                rows=((EVIL, LiveCell(actor=0, series="energy")),),
            ),
        ),
        moments=(Moment(time=0.5, title=EVIL),),
        notes=(EVIL,),
        title=EVIL,
    )


@pytest.fixture(scope="module")
def page(full: Content) -> str:
    return exported_page(full, command=f"morph view '{EVIL}'")


def test_no_name_from_a_file_becomes_an_element_or_a_script(page: str) -> None:
    read = Read(page)
    assert not [found for tag, found in read.tags if tag == "img"]
    # The numbers of the cells and the program of the page, no third.
    assert len(read.scripts) == 2
    assert not any("onerror" in found for _, found in read.tags)


def test_its_policy_lets_nothing_be_loaded_and_no_other_script_run(page: str) -> None:
    read = Read(page)
    said = next(found["content"] for tag, found in read.tags if found.get("http-equiv"))
    policy = dict(each.strip().split(" ", 1) for each in str(said).split(";"))
    assert policy["default-src"] == "'none'"
    assert policy["connect-src"] == "data: blob:"
    ours = base64.b64encode(hashlib.sha256(read.scripts[1].encode()).digest()).decode()
    assert f"'sha256-{ours}'" in policy["script-src"]
    assert "unsafe-inline" not in policy["script-src"]
    film = Read(str(read.first("iframe")["srcdoc"]))
    for script in film.scripts:
        hashed = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
        assert f"'sha256-{hashed}'" in policy["script-src"]


def test_cells_that_change_have_a_text_for_each_tenth_of_a_second(page: str) -> None:
    data = json.loads(Read(page).scripts[0])
    # 0 to 30 J over one second: 3 J each tenth, and the clock ends with the last picture.
    assert data["seconds"] == pytest.approx(1.0, abs=0.02)
    assert [float(text) for text in data["live"][0][:10]] == pytest.approx(
        [3.0 * at for at in range(10)], abs=0.06
    )


def test_it_says_what_made_it_and_of_which_body(page: str, full: Content) -> None:
    assert full.actors[0].figure.robot.sha256 in page
    assert "Made by morph" in page


def test_it_is_light_enough_to_be_sent(page: str) -> None:
    # viser's client has 0.82 MB, and a pendulum that swings for a second little more.
    assert 0.8e6 < len(page.encode()) < 1.1e6


def test_what_does_not_fit_has_fewer_pictures_a_second(shown: Content) -> None:
    assert recorded(shown, 10_000_000).rate == 30
    assert recorded(shown, 1).rate == 10


def test_a_body_at_rest_has_neither_player_nor_cursor(shown: Content) -> None:
    actor = shown.actors[0]
    rest = replace(actor.motion, position=actor.motion.position[:1], turn=actor.motion.turn[:1])
    page = exported_page(Content(actors=(replace(actor, motion=rest),)), title="Compare")
    assert Read(page).first("body") == {"class": "still"}
    assert "<title>Compare: pendulum</title>" in page


def test_the_camera_is_where_it_was(shown: Content) -> None:
    there = recorded(
        shown, 10_000_000, camera=Camera(position=(9.0, 8.0, 7.0), look_at=(0.0, 0.0, 1.0))
    )
    # Another camera is another recording, and all else of them is the same length.
    assert there.html != recorded(shown, 10_000_000).html


def test_positions_are_kept_to_a_part_in_a_hundred_thousand() -> None:
    rng = np.random.default_rng(100)
    values = rng.normal(size=1000) * 10.0 ** rng.integers(-6, 3, size=1000)
    # Half a step of 2^-16 of the next power of two, which is at most twice the value.
    assert np.all(np.abs(rounded(values) - values) <= np.abs(values) / FIGURES)
    assert np.array_equal(rounded(np.array([0.0, 1.0, -0.5])), [0.0, 1.0, -0.5])


def test_no_server_stays_behind(shown: Content) -> None:
    recorded(shown, 10_000_000)
    before = threading.active_count()
    recorded(shown, 10_000_000)
    assert threading.active_count() <= before
