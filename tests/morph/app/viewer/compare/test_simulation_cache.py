"""Bodies that are compared: who does what, and what is told of those who cannot."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from morph.app.viewer.compare.body_show import at_rest
from morph.app.viewer.compare.compare_content import told
from morph.app.viewer.compare.figures import COST, ENERGY, MARGIN
from morph.app.viewer.compare.panel import legend_html, states_html
from morph.app.viewer.compare.shared_work import Work
from morph.app.viewer.compare.simulation_cache import named
from morph.app.viewer.content import Content, LiveCell
from morph.app.viewer.view_request import ViewRequest
from morph.app.viewer.views.compare import maker
from morph.body.load import load
from morph.errors import EffectError, TaskError, ViewError
from morph.policy.pattern import Swing, pattern
from morph.policy.store import write_policy


def given(*names: str, **how: Any) -> ViewRequest:
    return ViewRequest(robots=tuple(map(load, names)), asked=names, **how)


def shown(*names: str, **how: Any) -> Content:
    """The content once all is computed."""
    view = maker(given(*names, **how))()
    view.complete()
    return view.content()


def column(content: Content, table: int, name: str) -> list[Any]:
    """The cells of a column of a table."""
    at = content.tables[table].head.index(name)
    return [row[at] for row in content.tables[table].rows]


def test_without_a_task_joints_go_through_their_ranges_by_no_physics() -> None:
    content = shown("cartpole", "so101", seconds=2.0)
    assert [actor.motion.pictures for actor in content.actors] == [121, 121]
    assert any(note.startswith("No physics") for note in content.notes)
    assert column(content, 0, "mass (kg)") == ["1", "0.632"]
    assert column(content, 0, "joints") == ["2", "6"]
    assert column(content, 0, "driven") == ["1", "6"]
    live = column(content, 1, "holding margin (%)")
    assert live == [LiveCell(actor=at, series=MARGIN) for at in (0, 1)]
    assert content.charts == ()


def test_bodies_do_their_task_side_by_side_and_zero_commands_let_a_pole_fall() -> None:
    content = shown("cartpole", "pendulum", task="balance")
    assert [actor.figure.name for actor in content.actors] == ["cartpole", "pendulum"]
    assert content.seconds == pytest.approx(5.0)
    for actor in content.actors:
        assert set(actor.motion.series) == {MARGIN, ENERGY, COST}
        # Nothing is commanded: nothing is spent, and a fallen pole costs.
        assert actor.motion.series[ENERGY].max() == 0.0
        assert actor.motion.series[MARGIN].min() == 100.0
        assert actor.motion.series[COST][-1] > 100.0
    assert column(content, 1, "goals") == [
        "0\N{NO-BREAK SPACE}of\N{NO-BREAK SPACE}2",
        "0\N{NO-BREAK SPACE}of\N{NO-BREAK SPACE}1",
    ]
    assert "pendulum: missed 1 goals: upright at hinge" in content.notes
    assert [chart.title for chart in content.charts] == ["Cost so far", "Energy so far"]
    colours = [line.colour for line in content.charts[0].lines]
    assert len(set(colours)) == 2
    end = content.charts[0].lines[0]
    assert end.time[-1] == pytest.approx(5.0)
    assert end.value[-1] == content.actors[0].motion.series[COST][-1]


def test_a_policy_of_a_folder_names_the_task_and_drives_its_body(tmp_path: Path) -> None:
    robot = load("pendulum")
    swings = {robot.actuators[0].name: Swing(offset=0.5)}
    folder = write_policy(pattern(robot, swings), tmp_path / "push", robot, task="balance")
    content = shown("pendulum", "pendulum", policies=(str(folder),))
    assert [actor.figure.name for actor in content.actors] == ["pendulum (1)", "pendulum (2)"]
    assert content.title.startswith("balance")
    spent = [actor.motion.series[ENERGY][-1] for actor in content.actors]
    assert spent[0] > 0.0
    assert spent[1] == 0.0


def test_a_body_that_cannot_do_the_task_stands_still_and_says_why() -> None:
    content = shown("cartpole", "biped", task="walk", seconds=0.2)
    assert [actor.motion.pictures for actor in content.actors] == [1, 13]
    (note,) = [note for note in content.notes if note.startswith("cartpole stands still")]
    assert "held to the world" in note
    assert column(content, 1, "cost")[0] == "\N{EN DASH}"
    # A run that is shorter than the task is not judged.
    assert column(content, 1, "goals") == ["\N{EN DASH}", "\N{EN DASH}"]


def test_a_task_that_no_body_can_do_is_refused_before_anything_is_served() -> None:
    with pytest.raises(TaskError, match=r"walk of cartpole.*held to the world"):
        maker(given("cartpole", "pendulum", task="walk"))


def test_what_the_command_line_got_wrong_is_refused_before_anything_is_served() -> None:
    with pytest.raises(TaskError, match=r"there is no task 'dance'"):
        maker(given("cartpole", task="dance"))
    with pytest.raises(EffectError, match=r"there is no world 'moon'"):
        maker(given("cartpole", world="moon"))
    with pytest.raises(ViewError, match=r"(?s)what is to be learned.*--task: balance, swing-up"):
        maker(given("cartpole", policies=("learned",)))


def test_a_world_takes_the_place_of_that_of_the_task() -> None:
    content = shown("sea_snake", world="water", seconds=0.1)
    assert content.actors[0].figure.wet
    assert not shown("sea_snake", seconds=0.1).actors[0].figure.wet


def test_bodies_that_share_a_name_are_numbered() -> None:
    cart, pole = load("cartpole"), load("pendulum")
    assert named((pole, cart, pole)) == ("pendulum (1)", "cartpole", "pendulum (2)")


def test_until_a_body_is_ready_it_stands_and_its_figures_are_open() -> None:
    rest = [at_rest(load("cartpole"), "cartpole")]
    content = told("balance", rest, [Work()])
    assert content.actors[0].motion.pictures == 1
    assert content.seconds == 0.0
    assert set(content.tables[1].rows[0][1:]) == {"\N{HORIZONTAL ELLIPSIS}"}


def test_all_persons_share_what_is_computed_and_choose_for_themselves() -> None:
    make = maker(given("cartpole", "pendulum", seconds=0.5))
    one, other = make(), make()
    one.restore({"task": "balance", "arrows": ["torque"]})
    one.complete()
    other.complete()
    assert one.content().charts != ()
    assert other.content().charts == ()
    other.restore(one.state())
    assert other.state() == {"task": "balance", "arrows": ["torque"]}
    motions = [[actor.motion.position for actor in view.content().actors] for view in (one, other)]
    assert all(a is b for a, b in zip(*motions, strict=True))


@pytest.mark.parametrize(
    ("state", "what"),
    [
        ({"task": "walk"}, r"a task 'walk' that these bodies do not share"),
        ({"task": ["balance"]}, r"a task \['balance'\]"),
        ({"arrows": ["wind"]}, r"arrows \['wind'\]"),
        ({"arrows": 3}, r"arrows 3"),
    ],
)
def test_a_state_of_other_bodies_is_refused(state: dict[str, Any], what: str) -> None:
    view = maker(given("cartpole", seconds=0.2))()
    with pytest.raises(ViewError, match=what):
        view.restore(state)


def test_names_and_reasons_are_never_html() -> None:
    work: Work[Any] = Work()
    work.told = "<b>looking</b>"
    html = states_html(["<script>alert(1)</script>"], [work])
    assert "<script>" not in html
    assert "&lt;script&gt;" in html
    assert "<b>" not in html
    assert "rgb(213, 94, 0)" in legend_html({"contact": "a & b"})
    assert "a &amp; b" in legend_html({"contact": "a & b"})
