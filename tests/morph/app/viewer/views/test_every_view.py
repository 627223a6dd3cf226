"""What every view must honour, whoever wrote it."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from morph.app.cli.main import main
from morph.app.viewer.content import Content, LiveCell
from morph.app.viewer.fragments import table_html
from morph.app.viewer.view import View
from morph.app.viewer.view_request import ViewRequest
from morph.app.viewer.views.views import VIEWS, makers
from morph.body.load import load
from morph.errors import ViewError
from morph.record.write import write
from morph.sim.simulator import Simulator


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Callable[[], View]]:
    """What makes each view, all from one command line."""
    folder = tmp_path_factory.mktemp("given")
    robot = load("pendulum")
    run = Simulator(robot).run(seconds=2.0, start={"hinge": 1.0}, command={"hinge": 0.1})
    write(run, folder / "run.parquet")
    bodies = ["cartpole", "rider_rigid_driven"]
    assert main(["align", *bodies, "--out", str(folder / "aligned"), "--quiet"]) == 0
    given = ViewRequest(
        robots=(robot, load("cartpole")),
        asked=("pendulum", "cartpole"),
        recordings=(folder / "run.parquet",),
        transfer=folder / "aligned",
    )
    return dict(zip(VIEWS, makers(given)[0], strict=True))


@pytest.fixture(params=VIEWS)
def view(request: pytest.FixtureRequest, made: dict[str, Callable[[], View]]) -> View:
    """One of the views, of a person of its own."""
    return made[request.param]()


@pytest.fixture
def finished(view: View) -> Content:
    """What it shows once nothing more is computed."""
    view.content()
    view.complete()
    return view.content()


def test_it_is_made_by_its_own_name(made: dict[str, Callable[[], View]]) -> None:
    assert {name: make().name for name, make in made.items()} == {name: name for name in VIEWS}
    assert [make().title for make in made.values()] == [name.title() for name in VIEWS]


def test_it_shows_a_body_at_once_and_when_it_is_complete(view: View, finished: Content) -> None:
    assert view.content().actors
    assert finished.actors


def test_every_number_of_a_motion_is_there_in_every_picture(finished: Content) -> None:
    for actor in finished.actors:
        motion, links = actor.motion, len(actor.figure.links)
        assert motion.position.shape == (motion.pictures, links, 3)
        assert motion.turn.shape == (motion.pictures, links, 4)
        assert np.isfinite(motion.position).all()
        # Quaternions of MuJoCo have length 1 to a few units of rounding, 2^-52 each.
        np.testing.assert_allclose(np.linalg.norm(motion.turn, axis=2), 1.0, atol=1e-9)
        assert {len(series) for series in motion.series.values()} <= {motion.pictures}
        for arrows in motion.arrows.values():
            assert arrows.shape[0] == motion.pictures
            assert arrows.shape[2:] == (2, 3)
        if motion.heat is not None:
            assert motion.heat.shape == (motion.pictures, links)
            assert ((motion.heat >= 0.0) & (motion.heat <= 1.0)).all()


def test_lines_end_on_links_that_are_there(finished: Content) -> None:
    for tie in finished.ties:
        for at, link in (tie.source, tie.target):
            assert link in finished.actors[at].figure.links


def test_cells_that_move_show_numbers_that_are_there(finished: Content) -> None:
    for table in finished.tables:
        for cell in (cell for row in table.rows for cell in row if isinstance(cell, LiveCell)):
            assert cell.series in finished.actors[cell.actor].motion.series
        assert {len(row) for row in table.rows} <= {len(table.head)}
        assert "<table" in table_html(table, finished.actors, 0.0)


def test_moments_lie_on_the_clock(finished: Content) -> None:
    for moment in finished.moments:
        assert 0.0 <= moment.time <= finished.seconds


def test_its_state_is_json_that_another_person_can_be_given(
    view: View, finished: Content, made: dict[str, Callable[[], View]]
) -> None:
    said = json.loads(json.dumps(view.state(), allow_nan=False))
    other = made[view.name]()
    other.restore(said)
    assert other.state() == view.state()
    other.complete()
    assert len(other.content().actors) == len(finished.actors)


@pytest.mark.parametrize(
    "state",
    [{"no such key": 1}, {"task": 7, "joints": 3, "hop": "x", "episode": [], "arrows": "no"}],
)
def test_a_state_that_is_not_its_own_is_refused_in_a_sentence(
    view: View, state: dict[str, object]
) -> None:
    with pytest.raises(ViewError) as told:
        view.restore(state)
    assert told.value.what
    assert told.value.fix


def test_what_one_person_shows_is_not_what_another_does(
    made: dict[str, Callable[[], View]],
) -> None:
    for make in made.values():
        assert make() is not make()


def test_a_view_that_was_not_given_what_it_needs_says_so(tmp_path: Path) -> None:
    given = ViewRequest(robots=(load("pendulum"),), asked=("pendulum",))
    with pytest.raises(ViewError, match=r"there is no view 'align'"):
        makers(given, "align")
    with pytest.raises(ViewError, match=r"nothing to show"):
        makers(ViewRequest(robots=(), asked=()))
