"""The double pendulum of DFKI: what the view tells is what the diagnosis told."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from morph.app.report.files import diagnosis_text
from morph.app.viewer.mismatch.choices import MismatchChoices
from morph.app.viewer.mismatch.load_case import load_case
from morph.app.viewer.mismatch.window import CORRECTED, DESCRIBED
from morph.app.viewer.view import View
from morph.app.viewer.view_request import ViewRequest
from morph.app.viewer.views.mismatch import maker
from morph.body.load import load
from morph.inference.diagnose import diagnose
from morph.physics.store import effects_text
from morph.record.load import load_recordings

BINDING = Path(__file__).resolve().parents[5] / "experiments" / "bindings" / "dfki_c0.toml"


@pytest.fixture(scope="module")
def given(recordings: Path, tmp_path_factory: pytest.TempPathFactory) -> ViewRequest:
    """The rig's runs, and a diagnosis of them whose budget ends before it finds anything."""
    root = recordings / "dfki_double_pendulum"
    robot = load("double_pendulum")
    runs = {each.name: each for each in load_recordings(BINDING, robot=robot, root=root)}
    found = diagnose(
        robot,
        [runs["run_00"], runs["run_01"]],
        held_out=[runs["run_03"]],
        horizon=1.0,
        budget=0.01,
    )
    folder = tmp_path_factory.mktemp("diagnosis")
    (folder / "diagnosis.json").write_text(diagnosis_text(found))
    (folder / "corrected.xml").write_text(found.corrected)
    (folder / "corrected.toml").write_text(effects_text(found.corrected_effects))
    return ViewRequest(
        robots=(robot,),
        asked=("double_pendulum",),
        recordings=(BINDING,),
        root=root,
        diagnosis=folder,
    )


@pytest.fixture(scope="module")
def made(given: ViewRequest) -> Callable[[], View]:
    """What makes the view."""
    return maker(given)


def test_the_errors_shown_are_those_of_the_diagnosis(given: ViewRequest) -> None:
    assert given.diagnosis is not None
    told = json.loads((given.diagnosis / "diagnosis.json").read_text())["fit"]["held_out_rmse"]
    case = load_case(given)
    take = case.take(MismatchChoices.of(case).ask)
    assert take.name == "run_03"
    for trace in take.traces:
        # diagnosis.json keeps six figures, and corrected.xml as many as MuJoCo writes.
        assert trace.rmse[DESCRIBED] == pytest.approx(told["nominal"][trace.channel], rel=1e-5)
        assert trace.rmse[CORRECTED] == pytest.approx(told["corrected"][trace.channel], rel=1e-3)
        assert trace.noise == pytest.approx(told["noise_floor"][trace.channel], rel=1e-5)
    assert told["corrected"] != told["nominal"]


def test_the_worst_moment_marked_is_the_one_that_the_diagnosis_located(
    given: ViewRequest, made: Callable[[], View]
) -> None:
    assert given.diagnosis is not None
    located = json.loads((given.diagnosis / "diagnosis.json").read_text())["located"]["times"]
    content = made().content()
    assert content.moments[0].time == pytest.approx(located[0]["start_s"], abs=1e-4)
    assert [each.title[:5] for each in content.moments] == ["worst"] * len(located)
    worst = content.actors[0].motion.marks
    assert worst is not None
    assert np.isfinite(worst[content.actors[0].motion.at(content.moments[0].time)]).all()


def test_the_page_has_the_recording_solid_and_a_ghost_of_each_model(
    made: Callable[[], View],
) -> None:
    content = made().content()
    solid, described, corrected = content.actors
    assert not solid.ghost
    assert described.ghost
    assert corrected.ghost
    assert described.colour != corrected.colour
    assert {actor.lane for actor in content.actors} == {0}
    assert solid.motion.heat is not None
    assert set(solid.motion.arrows) == {"wrench", "remaining"}
    names = [chart.title for chart in content.charts]
    assert "elbow.position" in names
    assert "elbow: missing torque" in names
    # Ten seconds at sixty pictures a second.
    assert solid.motion.pictures == pytest.approx(600, abs=5)
