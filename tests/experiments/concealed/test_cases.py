"""Cases of the benchmark: what is drawn, what is written, what stays sealed."""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from experiments.concealed.case import Case, draw_case
from experiments.concealed.generate import generate
from experiments.concealed.law import Law
from experiments.concealed.plant import Array, Plant
from experiments.concealed.seal import CASES, TRUTHS, open_seal
from experiments.concealed.simulate import GRID, Run, moving_state, simulate
from experiments.concealed.sizing import FINEST, WEAKEST
from experiments.concealed.submission import CASE_SCHEMA_FILE
from experiments.concealed.suites import LASTING, LAWS, SUITES
from experiments.concealed.ties import are_distinct, ties_of
from experiments.concealed.truth import Effect, Truth, replayed
from morph.body.load import load as load_robot
from morph.files import sha256
from morph.record.load import load_recordings

SECONDS = 3.0
BY_NAME = {law.name: law for law in LAWS}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with two cases with effects and a clean one."""
    made = tmp_path_factory.mktemp("benchmark")
    generate("development", 1, [1, 5], made, seconds=SECONDS, workers=2)
    generate("clean", 1, [4], made, seconds=SECONDS)
    return made


def test_a_case_is_the_same_to_the_byte_in_any_company(folder: Path, tmp_path: Path) -> None:
    generate("development", 1, [5], tmp_path, seconds=SECONDS)
    files = [path for path in tmp_path.rglob("*") if path.is_file()]
    assert len(files) == 11
    for path in files:
        assert path.read_bytes() == (folder / path.relative_to(tmp_path)).read_bytes()


def test_a_solver_is_told_nothing_of_the_truth(folder: Path) -> None:
    jsonschema = pytest.importorskip("jsonschema")
    schema = json.loads(CASE_SCHEMA_FILE.read_text())
    for case in (folder / CASES).iterdir():
        known = json.loads((case / "case.json").read_text())
        jsonschema.validate(known, schema)
        truth = (folder / TRUTHS / f"{case.name}.json").read_text()
        assert known["truth_sha256"] == sha256(truth)
        readable = "".join(
            path.read_text()
            for path in case.rglob("*")
            if path.suffix in (".json", ".xml", ".toml")
        )
        # MJCF calls the rotor's inertia armature.
        assert not any(law.name in readable for law in LAWS if law.name != "armature")


def test_morph_reads_the_description_and_the_recordings(folder: Path) -> None:
    for case in (folder / CASES).iterdir():
        robot = load_robot(str(case / "robot.xml"))
        assert not robot.findings
        runs = load_recordings(case / "recordings", robot=robot)
        assert len(runs) == 4
        for run in runs:
            assert run.seconds == pytest.approx(SECONDS, abs=0.06)
            wanted = {f"{joint.name}.position" for joint in robot.joints}
            wanted |= {f"{actuator.name}.command" for actuator in robot.actuators}
            assert wanted <= set(run.channels)


def test_a_clean_case_has_readings_that_its_true_plant_explains(folder: Path) -> None:
    (case,) = (folder / CASES).glob("clean*")
    truth = open_seal(case).about
    assert truth["answer"] == "none"
    assert truth["effects"] == []
    # Rounded starts and a step twice as long: far below one reading's error.
    assert truth["oracle_error"] < 0.5
    ratios = [x for kind in truth["factors"].values() for x in kind]
    assert all(0.75 <= x <= 1.25 and x != 1.0 for x in ratios)


def test_shares_of_a_suite_are_as_stated_and_its_laws_take_turns() -> None:
    suite = SUITES["development"]
    counts = Counter(suite.count(3, number) for number in range(40))
    assert counts == {1: 18, 2: 8, 3: 4, 0: 4, -1: 6}
    assert [SUITES["clean"].count(1, n) for n in range(5)] == [0] * 5
    orders = [tuple(each.count(1, n) for n in range(20)) for each in SUITES.values()]
    assert orders[0] != orders[1]
    assert not {law.name for law in suite.outside_laws()} & {
        law.name for law in SUITES["judge"].outside_laws()
    }


@pytest.mark.parametrize("number", [1, 5])
def test_every_effect_of_a_case_is_visible_and_no_gain_hides_in_its_trust(number: int) -> None:
    case = draw_case("development", 1, number, seconds=SECONDS)
    assert case.truth.effects
    assert min(case.strengths) >= WEAKEST


def _bare(family: str) -> Case:
    """Return a clean case of a family."""
    for number in range(200):
        case = draw_case("clean", 7, number, seconds=2.0) if _is(family, number) else None
        if case is not None:
            return case
    raise AssertionError(family)


def _is(family: str, number: int) -> bool:
    rng = np.random.default_rng([SUITES["clean"].number, 7, number, 0])
    from experiments.concealed.mechanisms import FAMILIES

    return str(rng.choice(list(FAMILIES))) == family


@pytest.fixture(scope="module")
def pendulum() -> Case:
    """Return a clean case of a pendulum that has neither damping nor a rotor."""
    return _bare("pendulum")


def readings(plant: Plant, sent: Run, start: Array) -> Array:
    """Return what the sensor shows in a run with given commands."""
    from experiments.concealed.readings import ideal_readings

    state = moving_state(plant, start, 0 * start)
    motion = simulate(plant, sent, state=state)
    return ideal_readings(plant, motion.q, sent.ticks, motion.step, 1)[:, 0]


def test_ties_are_exact_on_a_pendulum(pendulum: Case) -> None:
    truth = pendulum.truth
    base, axis, com = truth.base, truth.base.axis[0], truth.base.com[0]
    base = base.with_joint(0, count=0.0)
    sent = replayed(truth.runs[0], pendulum.motions[0])
    # Not at one of the path's ends, where a delay would show the command before the run.
    sent = replace(sent, feed=np.where(sent.ticks[:, None] * GRID < 0.1, sent.feed[0], sent.feed))
    start = truth.runs[0].start
    gravity = base.rotation[0].T @ base.gravity
    arm = com - (com @ axis) * axis
    scale = 1.3
    pairs = {
        ("viscous_friction", "linear_drag"): (
            {"b": 0.3 * float(np.sum(np.cross(axis, arm) ** 2))},
            {"x": 0.3, "y": 0.3, "z": 0.3, **dict(zip(("cx", "cy", "cz"), arm, strict=True))},
        ),
        ("torque_scale", "link_inertia"): (
            {"gain": scale}, {"mass": 1 / scale, "inertia": 1 / scale},
        ),
    }  # fmt: skip
    del gravity
    for (one, other), (these, those) in pairs.items():
        first = readings(BY_NAME[one].apply(base, 0, these), sent, start)
        second = readings(BY_NAME[other].apply(base, 0, those), sent, start)
        plain = readings(base, sent, start)
        # Equal figures but for round-off, which a second of motion does not magnify.
        np.testing.assert_allclose(first, second, atol=1e-9)
        assert np.abs(first - plain).max() > 1e-3
        tied = ties_of(truth, Effect(law=BY_NAME[one], place=0, figures=these))
        assert other in {tie.effect for tie in tied}


def test_back_emf_is_told_from_viscous_friction_where_drives_are_cut_off(pendulum: Case) -> None:
    def names(truth: Truth, law: Law) -> set[str]:
        return {tie.effect for tie in ties_of(truth, Effect(law=law, place=0, figures={}))}

    truth, law = pendulum.truth, BY_NAME["viscous_friction"]
    assert names(truth, law) == {"linear_drag"}
    powered = tuple(replace(run, reference=0 * run.feed) for run in truth.runs)
    assert names(replace(truth, runs=powered), law) == {"linear_drag", "back_emf"}


def test_a_load_on_a_level_cart_is_as_good_as_a_rotor() -> None:
    truth = _bare("cart_pole").truth
    load = Effect(law=BY_NAME["payload"], place=0, figures={"m": 0.3, "x": 0.0, "y": 0.0, "z": 0.0})
    q, v = np.zeros((1, 2)), np.array([[0.4, 1.0]])
    loaded = load.law.apply(truth.base, 0, load.figures)
    mass, bias = loaded.mass_and_bias(q, v)
    before, same = truth.base.mass_and_bias(q, v)
    np.testing.assert_allclose(mass[0] - before[0], [[0.3, 0.0], [0.0, 0.0]], atol=1e-12)
    np.testing.assert_allclose(bias, same, atol=1e-12)
    assert {tie.effect for tie in ties_of(truth, load)} == {
        "armature", "added_mass", "link_inertia",
    }  # fmt: skip
    tilt = Effect(law=BY_NAME["base_tilt"], place=0, figures={"roll": 0.1, "pitch": 0.1})
    assert not ties_of(replace(truth, effects=(tilt,)), load)


def test_twins_are_never_left_out_together(pendulum: Case) -> None:
    one, other, third = (
        Effect(law=BY_NAME[name], place=0, figures={})
        for name in ("sensor_bias", "com_offset", "cogging")
    )
    assert not are_distinct(replace(pendulum.truth, effects=(one, other)))
    assert are_distinct(replace(pendulum.truth, effects=(one, third)))


@pytest.fixture(scope="module")
def arm() -> Case:
    """Return an industrial arm with the physics of real drives, over one window a run."""
    return draw_case("arms", 1, 0, seconds=1.0)


def test_windows_hardly_depend_on_the_step(arm: Case) -> None:
    truth, motion = arm.truth, arm.motions[1]
    sent = replayed(truth.runs[1], motion)
    ends = [
        simulate(truth.plant(1), sent, state=motion.saved[0], finer=finer).q[::finer]
        for finer in (1, 2, 4)
    ]
    n = len(truth.error)
    coarse, written = (
        float(np.sqrt((((end - ends[2])[:, :n] / truth.error) ** 2).mean())) for end in ends[:2]
    )
    # An arm with stiction and springs at every joint: what is written is off by less than a
    # twentieth of a reading's error after a second, and half the step leaves less.
    assert written < 0.05
    assert written < coarse


def test_an_arm_has_the_physics_of_real_drives(arm: Case) -> None:
    names = Counter(effect.law.name for effect in arm.truth.effects)
    joints = arm.mechanism.plant.count
    assert joints in (6, 7)
    assert names == {
        "stribeck_friction": joints, "load_dependent_friction": joints,
        "series_elasticity": joints, "payload": 1,
    }  # fmt: skip


@pytest.fixture(scope="module")
def begun() -> Case:
    """A case in which a law begins during a run."""
    every = (draw_case("events", 1, number, seconds=SECONDS) for number in range(20))
    return next(each for each in every if each.truth.effects and each.truth.effects[0].since)


def test_a_law_that_begins_acts_from_its_time_on_and_in_later_runs(begun: Case) -> None:
    truth = begun.truth
    run, since = truth.effects[0].since or (0, 0)
    assert 0 < run < len(truth.runs) - 1
    always = replace(truth, effects=tuple(replace(e, since=None) for e in truth.effects))
    never = replace(truth, effects=())
    for number, motion in enumerate(begun.motions):
        other = (never if number < run else always).move(number, FINEST)
        if number != run:
            assert np.array_equal(motion.reading, other.reading)
            assert np.array_equal(motion.command, other.command)
    # In its run the motion is that without it, to the bit, and then another.
    before, motion = never.move(run, FINEST), begun.motions[run]
    steps = since * round(GRID / motion.step)
    assert np.array_equal(motion.q[: steps + 1], before.q[: steps + 1])
    early = truth.runs[run].ticks < since
    assert np.array_equal(motion.command[early], before.command[early])
    assert np.array_equal(motion.reading[early], before.reading[early])
    assert not np.array_equal(motion.reading[~early], before.reading[~early])


def test_half_of_the_cases_with_events_are_pushes_and_half_begin() -> None:
    suite = SUITES["events"]
    counts = [suite.count(1, number) for number in range(20)]
    assert sorted(counts) == [0] * 4 + [1] * 16
    assert [{law.name for law in suite.events_of(kin)} for kin in (0, 1)] == [
        {"external_push"},
        set(LASTING),
    ]
