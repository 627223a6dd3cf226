"""The swimmer swims for the reasons that it should, and for no others."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from experiments.swim.steer import Depth, steered
from experiments.swimmer import Swimmer, gaits, main, summed
from morph.body.load import load
from morph.physics.store import load_effects
from morph.policy.store import load_policy


@pytest.fixture(scope="module")
def swimmer() -> Swimmer:
    return Swimmer(load("hexapod_swimmer"))


def forward(swimmer: Swimmer, world: str, gait: str) -> float:
    return swimmer.run(world, gait, gaits(swimmer.robot)[gait], 4.0).forward


def test_a_swimmer_that_does_nothing_stays_where_it_is(swimmer: Swimmer) -> None:
    still = swimmer.run("water", "rest", gaits(swimmer.robot)["rest"], 4.0)
    # The paddles are heavier than water and sag: 41 g * 9.81 * 0.088 m / 3 N m/rad = 0.012 rad,
    # 1 mm at their middles. Their 2 kg, with the water they move, lift the hull's 17 kg by
    # 0.12 mm at most.
    assert max(abs(still.forward), abs(still.left), abs(still.up)) < 1.2e-4
    assert still.pitch_deg < 0.05


def test_a_symmetric_stroke_moves_it_by_thrust_alone(swimmer: Swimmer) -> None:
    # Six paddles push with 0.53 N at first, on 17 kg and 7 kg of water: 0.13 m/s2, which in 4 s
    # without drag would be 1 m; drag leaves some of it.
    assert 0.3 < forward(swimmer, "water", "straight") < 1.0
    # Without, only what the beginning of the stroke leaves: a few mm (the thesis found 2.7).
    assert abs(forward(swimmer, "water without thrust", "straight")) < 0.01
    assert abs(forward(swimmer, "perfect fluid", "straight")) < 0.001


def test_reversed_a_symmetric_stroke_swims_on_and_rowing_turns_round(swimmer: Swimmer) -> None:
    # Thrust goes with the square of speed: a stroke backward in time is the same stroke.
    there, back = (forward(swimmer, "water", each) for each in ("straight", "straight_reversed"))
    assert back == pytest.approx(there, rel=0.05)
    # Drag goes with its sign: what rows forward rows backward when time runs backward.
    there, back = (
        forward(swimmer, "water without thrust", each) for each in ("row", "row_reversed")
    )
    assert there > 0.1
    assert back == pytest.approx(-there, rel=0.05)


def test_half_a_stroke_on_the_left_turns_left(swimmer: Swimmer) -> None:
    every = gaits(swimmer.robot)
    turned = swimmer.run("water", "left", every["left"], 4.0)
    straight = swimmer.run("water", "straight", every["straight"], 4.0)
    assert turned.yaw_deg > 20.0
    assert turned.left > 0.02
    assert abs(straight.yaw_deg) < 0.5


def test_it_dives_where_it_is_told_and_stays(swimmer: Swimmer) -> None:
    held = summed("water", "held", steered(swimmer.worlds["water"], Depth(), 6.0))
    assert held.forward > 0.6
    assert abs(held.up) < 0.02
    assert held.deepest > -0.02
    dived = summed("water", "dived", steered(swimmer.worlds["water"], Depth(height=-0.2), 12.0))
    assert -0.22 < dived.up < -0.1


def test_it_holds_its_depth_where_it_would_sink(swimmer: Swimmer) -> None:
    # 100 g pull with 0.98 N; in 6 s they would draw 17 kg, 6 * 0.06 kg of blades and 34 kg of
    # water down by 0.98 / 52 * 36 / 2 = 0.34 m, less what drag holds back.
    world = "water, 100 g too heavy"
    sunk = swimmer.run(world, "rest", gaits(swimmer.robot)["rest"], 6.0)
    assert -0.34 < sunk.up < -0.2
    held = summed(world, "held", steered(swimmer.worlds[world], Depth(), 12.0))
    assert held.forward > 2.0
    assert held.deepest > -0.12
    assert held.up > -0.08


def test_on_a_floor_it_walks_and_only_with_friction(swimmer: Swimmer) -> None:
    assert forward(swimmer, "floor", "tripod") > 0.4
    assert abs(forward(swimmer, "floor without friction", "tripod")) < 0.05
    # What swims does not walk: the hull lies on its belly and the paddles beat beside it.
    assert abs(forward(swimmer, "floor", "straight")) < 0.02


def test_gaits_and_worlds_are_written_for_the_command_line(
    swimmer: Swimmer, tmp_path: Path
) -> None:
    assert main(["--policies", str(tmp_path)]) == 0
    assert load_effects(tmp_path / "water.toml") == swimmer.worlds["water"].effects
    for name, gait in gaits(swimmer.robot).items():
        assert load_policy(tmp_path / name, swimmer.robot) == gait


def test_the_study_prints_its_rows_as_json(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--seconds", "0.4", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert len(told["rows"]) == 20
    assert {each["world"] for each in told["rows"]} == {
        *("water", "water without thrust", "perfect fluid", "floor", "floor without friction"),
        "water, 100 g too heavy",
    }
    assert [each["amplitude"] for each in told["mean_thrust"]] == [0.25, 0.5, 0.5, 0.5, 0.8]


def test_a_run_of_no_seconds_is_unusable_input(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--seconds", "-1"]) == 2
    assert "seconds" in capsys.readouterr().err
