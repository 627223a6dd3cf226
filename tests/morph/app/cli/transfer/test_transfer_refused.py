from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from morph.alignment.errors import MapError
from morph.body.load import load
from morph.policy.pattern import pattern
from morph.policy.store import write_policy
from morph.policy_transfer.balancers import balancer
from morph.policy_transfer.mapped.feedback import holding
from morph.policy_transfer.policy_conversion import stored


def words(*more: str) -> list[str]:
    known = {"--from": "learned", "--out": "out"}
    chain = [] if "--chain" in more else ["--chain", "cartpole", "rider_rigid_driven"]
    rest = [word for name, value in known.items() if name not in more for word in (name, value)]
    return ["transfer", *rest, *chain, *more]


@pytest.mark.parametrize(
    ("more", "where", "what"),
    [
        (("--chain", "cartpole"), "--chain", "1 bodies make no hop"),
        (("--samples", "20", "30"), "--samples", "2 numbers are given for 1 hops"),
        (("--samples", "9"), "--samples", "9 transitions tell nothing of a body"),
        (("--samples", "100001"), "--samples", "100001 transitions would take longer"),
        (("--trials", "0"), "--trials", "0 runs judge nothing"),
        (("--noise", "nan"), "--noise", "nan is no noise"),
        (("--noise", "0.2"), "--noise", "0.2 is no noise"),
        (("--repeats", "-1"), "--repeats", "-1 is no count"),
        (("--scratch", "-1"), "--scratch", "-1 is no count"),
        (("--seed", "-1"), "--seed", "-1 is no seed"),
        (("--task", "balanc"), "morph.task", "there is no task 'balanc'"),
        (("--task", "swim"), "--task", "swim is not about a state of rest"),
        (("--out", " "), "--out", "no folder is named"),
        (("--from", "nowhere"), "nowhere/policy.json", "there is no such file"),
    ],
)
def test_what_cannot_be_used_is_refused_before_any_work(
    bench: Any, more: tuple[str, ...], where: str, what: str
) -> None:
    said = bench.refused(*words(*more))
    assert said["where"] == where
    assert said["what"].startswith(what)
    assert bench.knowing.calls == 0


def test_a_body_that_shares_no_quantity_is_refused(bench: Any) -> None:
    said = bench.refused(*words("--chain", "cartpole", "swimmer_three_links"))
    assert said["where"] == "body swimmer_three_links"
    assert said["what"].startswith("it shares no quantity of balance")


def test_a_body_that_carries_nothing_is_refused(bench: Any) -> None:
    said = bench.refused(*words("--chain", "cartpole", "pendulum"))
    assert said["where"] == "body pendulum"
    # One link with a mass, and that is the one which the first joint turns.
    assert said["what"].startswith("it shares no quantity of balance: nothing with a mass stands")


def test_an_unknown_body_is_refused(bench: Any) -> None:
    said = bench.refused(*words("--chain", "cartpole", "ridr"))
    assert "no robot is called 'ridr'" in said["what"]


@pytest.mark.parametrize("how", ["free", "free:l_foot", "flying:l_foot,r_foot", ""])
def test_a_skateboard_that_is_not_one_is_refused(bench: Any, how: str) -> None:
    said = bench.refused(*words("--chain", "cartpole", f"humanoid@{how}"))
    assert said["what"] == f"{how!r} is no skateboard with two feet on it"


def test_the_policy_of_another_body_is_refused_by_its_hash(bench: Any) -> None:
    there = balancer("rider_rigid_driven")
    gain = holding(there)
    write_policy(stored(there, gain, 0.0 * gain[:, 0]), Path("other"), there.task.robot)
    said = bench.refused(*words("--from", "other"))
    assert said["where"] == "other/policy.json"


def test_a_policy_that_does_not_look_is_refused(bench: Any) -> None:
    robot = load("cartpole")
    write_policy(pattern(robot, {}, period=0.02), Path("blind"), robot)
    said = bench.refused(*words("--from", "blind"))
    assert said["what"].startswith("it does not look at the body")


def test_a_policy_of_another_control_period_is_refused(bench: Any) -> None:
    robot = load("cartpole")
    write_policy(pattern(robot, {}, period=0.05), Path("slow"), robot)
    said = bench.refused(*words("--from", "slow"))
    assert said["where"] == "--from slow"
    assert said["what"] == "it commands every 0.05 s, and balance counts every 0.02 s"


def test_a_first_hop_without_a_map_leaves_nothing(bench: Any) -> None:
    bench.knowing.failing = {1: MapError("it cannot be inverted", where="map", fix="take another")}
    said = bench.refused(*words("--samples", "20", "--quiet"))
    assert (said["where"], said["what"]) == ("map", "it cannot be inverted")


def test_a_folder_of_something_else_is_refused(bench: Any) -> None:
    Path("out").mkdir()
    Path("out/mine.txt").write_text("mine")
    said = bench.refused(*words())
    assert said["what"] == "the folder is not empty and holds nothing of morph transfer"


def test_the_folder_of_another_transfer_is_refused(bench: Any, capsys: Any) -> None:
    bench.transfer("--quiet")
    capsys.readouterr()
    said = bench.refused(*bench.words("--seed", "1"))
    assert said["what"] == "the folder holds a transfer with other seed"


def test_fresh_does_not_remove_the_policy_that_is_given(bench: Any, capsys: Any) -> None:
    bench.transfer("--quiet")
    capsys.readouterr()
    said = bench.refused(*bench.words("--from", "out/policy", "--fresh"))
    assert said["what"].startswith("--fresh would remove what --from names")
