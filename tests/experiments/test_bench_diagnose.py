from __future__ import annotations

import numpy as np
import pytest

from experiments.bench_diagnose import ratio, report
from experiments.incumbent import figures, with_figures
from morph.body.load import load as load_robot
from morph.body.spec import spec_of
from morph.sim.simulator import Simulator

ROBOT = load_robot("double_pendulum")


def test_sysid_is_given_twelve_figures_with_the_description_inside_their_bounds() -> None:
    found = figures(ROBOT)
    assert len({figure.name for figure in found}) == len(found) == 12
    assert all(figure.low <= figure.nominal < figure.high for figure in found)


def test_the_description_s_own_figures_give_the_description_back() -> None:
    same = with_figures(ROBOT, {figure.name: figure.nominal for figure in figures(ROBOT)})
    before, after = (Simulator(robot).model for robot in (ROBOT, same))
    for name in ("body_mass", "body_ipos", "body_inertia", "dof_armature", "dof_damping"):
        # The centre's distance times its direction rounds in the last place.
        assert np.allclose(getattr(after, name), getattr(before, name), rtol=1e-12, atol=0.0)


def test_each_figure_is_written_where_its_name_says() -> None:
    values = {figure.name: figure.nominal for figure in figures(ROBOT)}
    values |= {"mass:lower": 0.7, "com:upper": 0.25, "inertia:lower": 0.004}
    values |= {"damping:shoulder": 0.01, "frictionloss:elbow": 0.05, "armature:elbow": 0.006}
    model = Simulator(with_figures(ROBOT, values)).model
    assert model.body("lower").mass[0] == pytest.approx(0.7)
    assert list(model.body("upper").ipos) == pytest.approx([0.0, 0.0, -0.25])
    assert model.body("lower").inertia[:2] == pytest.approx([0.004, 0.004])
    assert list(np.ravel(model.dof_damping)[:1]) == pytest.approx([0.01])
    assert list(model.dof_frictionloss) == pytest.approx([0.0, 0.05])
    assert model.dof_armature[1] == pytest.approx(0.006)


def test_writing_a_figure_twice_is_writing_it_once() -> None:
    # sysid writes every candidate into one and the same spec.
    spec = spec_of(ROBOT)
    (inertia,) = [figure for figure in figures(ROBOT) if figure.name == "inertia:upper"]
    inertia.write(spec, 0.002)
    inertia.write(spec, 0.002)
    assert max(spec.body("upper").inertia) == pytest.approx(0.002)


def test_the_ratio_of_errors_is_the_geometric_mean_over_joints() -> None:
    # Half and a quarter: sqrt(1/2 * 1/4) = 0.35355.
    halved = ratio({"a": 0.1, "b": 0.1}, {"a": 0.2, "b": 0.4})
    assert halved == pytest.approx(0.125**0.5)


def test_the_report_says_how_long_each_took_and_what_it_pointed_at(
    capsys: pytest.CaptureFixture[str],
) -> None:
    rows = {name: {"shoulder": 0.04, "elbow": 0.06} for name in ("morph", "sysid", "budgeted")}
    score = {"horizon_s": None, "rmse": rows, "error_ratio": 1.0, "error_ratio_budgeted": 1.25}
    report(
        {
            "seconds": {"morph": 30.0, "sysid": 60.0},
            "pointed_at": {"morph": "coulomb_friction@elbow", "sysid": "nothing"},
            "time_ratio": 0.5,
            "held_out": ["run_03"],
            "scores": [score],
        }
    )
    said = capsys.readouterr().out
    assert "morph: 30.0 s; pointed at coulomb_friction@elbow" in said
    assert "sysid: 60.0 s; pointed at nothing" in said
    assert "whole episodes" in said
    assert "in the same seconds: 1.250" in said


def test_figures_that_are_not_named_stay_as_described() -> None:
    changed = Simulator(with_figures(ROBOT, {"frictionloss:elbow": 0.1})).model
    assert list(changed.dof_frictionloss) == [0.0, 0.1]
    assert np.array_equal(changed.body_mass, Simulator(ROBOT).model.body_mass)
