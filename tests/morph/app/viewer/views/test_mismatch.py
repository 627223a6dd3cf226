"""The view's knobs, what they choose, and how it is kept, without a browser."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from morph.app.viewer.clock import PlaybackClock
from morph.app.viewer.mismatch.case import MismatchCase
from morph.app.viewer.mismatch.diagnosed import Diagnosed, DiagnosedFinding, Event
from morph.app.viewer.mismatch.window import CORRECTED, DESCRIBED
from morph.app.viewer.views.mismatch import Mismatch
from morph.body.load import load
from morph.body.robot import Robot
from morph.errors import MorphError, SimulationFailed, ViewError
from morph.physics.joint.coulomb_friction import CoulombFriction
from morph.record.recording import Recording
from morph.sim.simulator import Simulator


class Knob:
    """A handle of the page; `turn` is what a person does."""

    def __init__(self, label: str, options: tuple[str, ...] = (), value: str = "") -> None:
        self.label, self.options, self.value, self.visible = label, options, value, True
        self.acts: list[Callable[[Any], None]] = []
        self._impl = SimpleNamespace(sync_cb=None)

    def on_update(self, act: Callable[[Any], None]) -> None:
        self.acts.append(act)

    on_click = on_update

    def turn(self, value: str) -> None:
        assert value in self.options
        self.value = value
        self._impl.sync_cb(1, {"value": value})
        for act in self.acts:
            act(SimpleNamespace(client_id=1))


class Gui:
    """What a page is told to add."""

    def __init__(self) -> None:
        self.knobs: dict[str, Knob] = {}
        self.html: list[str] = []

    def add_html(self, content: str) -> None:
        self.html.append(content)

    def add_dropdown(self, label: str, options: tuple[str, ...], initial_value: str) -> Knob:
        self.knobs[label] = Knob(label, options, initial_value)
        return self.knobs[label]

    def add_button_group(self, label: str, options: tuple[str, ...]) -> Knob:
        self.knobs[label] = Knob(label, options)
        return self.knobs[label]


class Page:
    """A session whose long work is done at once."""

    def __init__(self, view: Mismatch) -> None:
        self.view, self.clock, self.gui = view, PlaybackClock(), Gui()
        self.chosen: list[tuple[int, str | None]] = []
        self.said: list[str] = []
        self.stage = SimpleNamespace(choose=lambda at, link: self.chosen.append((at, link)))
        self.client = SimpleNamespace(atomic=nullcontext)
        self.show()
        view.panel(self.gui, self)  # type: ignore[arg-type]

    def do(self, what: Callable[[], None]) -> None:
        what()

    def later(self, work: Callable[[], Any], then: Callable[[Any], None]) -> None:
        try:
            found = work()
        except MorphError as error:
            self.say(error.what, bad=True)
            return
        then(found)

    def show(self) -> None:
        self.content = self.view.content()
        self.clock.lasts(self.content.seconds)

    def jump(self, to: float) -> None:
        self.clock.playing = False
        self.clock.seek(to)

    def say(self, text: str, *, bad: bool = False) -> None:
        self.said.append(text)


def swings(robot: Robot, name: str, seconds: float = 4.0) -> Recording:
    """Return a recording of a pendulum whose hinge rubs, as nobody said."""
    rubbing = CoulombFriction(joint="hinge", c=0.2)
    return Simulator(robot, (rubbing,)).run(
        seconds=seconds,
        start={"hinge": 0.3},
        command={"hinge": lambda t: 1.5 * np.sin(2.0 * t)},
        name=name,
    )


@pytest.fixture(scope="module")
def case() -> MismatchCase:
    """Three runs of a pendulum, and a diagnosis that found its friction."""
    robot = load("pendulum")
    effect = CoulombFriction(joint="hinge", c=0.2)
    diagnosed = Diagnosed(
        folder=Path("nowhere"),
        verdict="mismatch",
        findings=(
            DiagnosedFinding(
                effect=effect, statement="<b>It rubs</b>", figures="c = 0.2, 97 % sure"
            ),
        ),
        stretches=(),
        horizon=1.0,
        train=("first",),
        held_out=("<i>second</i>",),
        by_time=False,
        robot_sha256=robot.sha256,
        recordings_sha256={},
        command="",
        corrected=robot,
        effects=(effect,),
        events=(
            Event(episode="first", time=1.5, title="change: coulomb_friction@hinge"),
            Event(episode="long", time=26.0, title="external_push@pole"),
        ),
    )
    runs = swings(robot, "first"), swings(robot, "<i>second</i>"), swings(robot, "long", 27.0)
    return MismatchCase(robot, runs, diagnosed)


@pytest.fixture
def page(case: MismatchCase) -> Iterator[Page]:
    """One person's page."""
    page = Page(Mismatch(case))
    yield page
    assert page.said == []


def test_it_begins_with_a_run_that_no_model_had_seen(page: Page) -> None:
    assert page.gui.knobs["recording"].value == "<i>second</i> (never seen)"
    assert page.content.actors[0].title == "<i>second</i>"
    assert page.content.seconds == pytest.approx(4.0, abs=0.02)


def test_what_files_say_is_no_html(page: Page) -> None:
    assert any("&lt;b&gt;It rubs&lt;/b&gt;" in each for each in page.gui.html)
    assert not any("<b>It" in each for each in page.gui.html)


def test_another_run_is_shown_from_its_start(page: Page) -> None:
    page.clock.seek(2.0)
    page.gui.knobs["recording"].turn("first")
    assert page.content.actors[0].title == "first"
    assert page.clock.time == 0.0


def test_a_long_run_is_shown_window_by_window(page: Page) -> None:
    windows = page.gui.knobs["window"]
    assert not windows.visible
    page.gui.knobs["recording"].turn("long")
    assert windows.visible
    assert windows.options == ("0 to 20 s", "20 to 27 s")
    assert page.content.seconds == pytest.approx(20.0, abs=0.02)
    windows.turn("20 to 27 s")
    assert page.content.seconds == pytest.approx(7.0, abs=0.02)
    assert "20 to 27 s" in page.content.tables[0].title
    page.gui.knobs["recording"].turn("first")
    assert not windows.visible


def test_an_open_loop_replaces_the_restarts_and_leaves_the_clock(page: Page) -> None:
    page.clock.seek(1.5)
    assert "restarted every 1 s" in page.content.tables[0].title
    page.gui.knobs["simulation"].turn("open loop")
    assert "open loop" in page.content.tables[0].title
    assert page.clock.time == 1.5


def test_either_model_is_shown_or_both(page: Page) -> None:
    assert len(page.content.actors) == 3
    page.gui.knobs["models"].turn("corrected")
    _, ghost = page.content.actors
    assert ghost.colour == (0, 158, 115)
    assert page.content.tables[0].head == ("", "corrected", "noise")
    assert set(page.content.actors[0].motion.arrows) == {"remaining"}


def test_links_may_keep_their_own_colours(page: Page) -> None:
    assert page.content.actors[0].motion.heat is not None
    page.gui.knobs["links by"].turn("missing force")
    assert any("missing at their joint" in note for note in page.content.notes)
    page.gui.knobs["links by"].turn("nothing")
    assert page.content.actors[0].motion.heat is None


def test_a_finding_is_shown_where_its_force_is_missing(case: MismatchCase, page: Page) -> None:
    page.gui.knobs["show finding"].turn("1")
    assert not page.clock.playing
    assert page.chosen[-1] == (0, case.robot.joints[0].link)
    missed = case.take(page.view.chosen.ask).missing[DESCRIBED]
    force = np.interp(page.clock.time, missed.time, missed.force[:, 0])
    # Of friction 0.2 N m is missing in full motion, and less about a reversal.
    assert abs(force) > 0.15
    assert page.clock.time in [each.time for each in page.content.moments]


def test_changes_and_pushes_are_moments_of_their_window(page: Page) -> None:
    def events() -> list[tuple[float, str]]:
        every = [(each.time, each.title) for each in page.content.moments]
        return [(t, title) for t, title in every if title.startswith(("change", "external"))]

    page.gui.knobs["recording"].turn("first")
    assert events() == [(1.5, "change: coulomb_friction@hinge")]
    page.gui.knobs["recording"].turn("long")
    assert events() == []
    page.gui.knobs["window"].turn("20 to 27 s")
    # The push begins 26 s after the recording, 6 s after the window.
    assert events() == [(pytest.approx(6.0), "external_push@pole")]


def test_what_is_chosen_is_kept_and_comes_back(case: MismatchCase, page: Page) -> None:
    page.gui.knobs["recording"].turn("long")
    page.gui.knobs["window"].turn("20 to 27 s")
    page.gui.knobs["simulation"].turn("open loop")
    page.gui.knobs["models"].turn("as described")
    page.gui.knobs["links by"].turn("missing force")
    state = page.view.state()
    other = Mismatch(case)
    other.restore(state)
    assert other.state() == state
    again = Page(other)
    assert again.gui.knobs["window"].value == "20 to 27 s"
    assert again.gui.knobs["simulation"].value == "open loop"
    assert again.gui.knobs["models"].value == "as described"
    assert [each.title for each in again.content.actors] == ["long", ""]


@pytest.mark.parametrize(
    "state",
    [
        {"recording": "third"},
        {"recording": 3},
        {"window": 1},
        {"window": -1},
        {"window": True},
        {"horizon_s": 0.0},
        {"horizon_s": "x"},
        {"horizon_s": float("nan")},
        {"models": "best"},
        {"colouring": None},
        {"colour": "missing force"},
    ],
)
def test_a_state_that_does_not_fit_is_refused(case: MismatchCase, state: dict[str, Any]) -> None:
    with pytest.raises(ViewError, match=r"saved view of mismatch: there is no"):
        Mismatch(case).restore(state)


def test_what_cannot_be_computed_is_not_chosen(
    case: MismatchCase, monkeypatch: pytest.MonkeyPatch
) -> None:
    page = Page(Mismatch(case))
    page.gui.knobs["recording"].turn("first")

    @contextmanager
    def failing() -> Iterator[None]:
        def fails(self: MismatchCase, ask: object) -> None:
            raise SimulationFailed("it fell apart", where="here", fix="none")

        with monkeypatch.context() as patch:
            patch.setattr(MismatchCase, "take", fails)
            yield

    with failing():
        page.gui.knobs["recording"].turn("long")
    assert page.said == ["it fell apart"]
    assert page.gui.knobs["recording"].value == "first"
    assert page.view.content().actors[0].title == "first"


def test_two_people_choose_apart_and_share_what_is_computed(case: MismatchCase) -> None:
    one, other = Page(Mismatch(case)), Page(Mismatch(case))
    one.gui.knobs["recording"].turn("first")
    assert other.content.actors[0].title == "<i>second</i>"
    assert case.take(one.view.chosen.ask) is case.take(one.view.chosen.ask)
    assert {model.name for model in case.models} == {DESCRIBED, CORRECTED}
