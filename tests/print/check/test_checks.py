from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from morph.print.check.checks import CHECKS, Rule
from morph.print.check.subject import Subject
from morph.print.mesh import Mesh

Make = Callable[..., Mesh]


@pytest.mark.parametrize("rule", CHECKS, ids=lambda rule: rule.name)
def test_every_check_passes_a_cube_and_says_what_it_found(
    rule: Rule, box: Make, subject: Callable[..., Subject]
) -> None:
    found = rule.look(subject(box(20.0, 20.0, 20.0)))
    assert (found.verdict, found.name, found.part) == ("passed", rule.name, "part")
    assert found.what
    assert not found.fix


@pytest.mark.parametrize("rule", CHECKS, ids=lambda rule: rule.name)
def test_no_check_depends_on_where_a_part_is_or_how_it_is_turned(
    rule: Rule, box: Make, beside: Make, subject: Callable[..., Subject]
) -> None:
    mesh = beside(box(40.0, 30.0, 3.0), box(0.8, 20.0, 10.0, at=(0.0, 0.0, 6.5)))
    turn, _ = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = turn * np.sign(np.linalg.det(turn)), (500.0, -300.0, 70.0)
    before, after = rule.look(subject(mesh)), rule.look(subject(mesh.moved(pose)))
    assert before.verdict == after.verdict


@pytest.mark.parametrize(
    ("spoil", "name"),
    [
        (lambda box, beside: box(0.02, 0.02, 0.02), "extent"),
        (lambda box, beside: box(2e4, 2e4, 2e4), "extent"),
        (lambda box, beside: None, "extent"),
        (
            lambda box, beside: Mesh(vertices=box(9, 9, 9).vertices, faces=box(9, 9, 9).faces[1:]),
            "manifold",
        ),
        (lambda box, beside: beside(box(9, 9, 9), box(9, 9, 9, at=(20, 0, 0))), "one solid"),
        (lambda box, beside: beside(box(20, 20, 20), box(20, 20, 20, at=(9, 3, 3))), "overlap"),
        (lambda box, beside: box(60.0, 40.0, 0.3), "wall"),
        (lambda box, beside: box(400.0, 20.0, 20.0), "bed fit"),
    ],
)
def test_each_check_finds_what_it_is_for_and_says_how_to_put_it_right(
    spoil: Callable[[Make, Make], Mesh | None],
    name: str,
    box: Make,
    beside: Make,
    subject: Callable[..., Subject],
) -> None:
    rule = next(rule for rule in CHECKS if rule.name == name)
    found = rule.look(subject(spoil(box, beside)))
    assert found.verdict == ("noted" if name == "bed fit" else "refused")
    assert found.fix


def test_names_of_checks_are_told_apart() -> None:
    assert len({rule.name for rule in CHECKS}) == len(CHECKS)
