"""`morph print` with a policy that it cannot use: told before anything is divided or sliced."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from morph.app.cli.main import main
from morph.body.load import load
from morph.policy.pattern import pattern
from morph.policy.store import write_policy
from morph.task.tasks import task


def spoilt(folder: Path) -> None:
    path = next(folder.glob("*.safetensors"))
    path.write_bytes(path.read_bytes()[:-8])


def other(folder: Path) -> None:
    path = folder / "policy.json"
    path.write_text(path.read_text().replace('"balance"', '"fly"'))


@pytest.fixture
def learned(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of a policy for the balance of the cart-pole."""
    monkeypatch.chdir(tmp_path)
    robot = load("cartpole")
    asked = task("balance", robot)
    still = pattern(robot, {}, period=asked.period)
    return write_policy(
        still, Path("out") / "policy", robot, task=asked.name, task_sha256=asked.sha256
    )


@pytest.mark.parametrize(
    ("robot", "change", "says"),
    [
        ("pendulum", lambda folder: None, "cartpole"),
        ("cartpole", spoilt, "safetensors"),
        ("cartpole", other, "policy.json"),
        ("cartpole", lambda folder: (folder / "policy.json").unlink(), "policy.json"),
        ("cartpole", shutil.rmtree, "out"),
    ],
)
def test_a_policy_that_cannot_be_used_is_refused_at_once(
    robot: str,
    change: Callable[[Path], None],
    says: str,
    learned: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    def never(*_: object) -> None:
        raise AssertionError("it was divided before its policy was looked at")

    monkeypatch.setattr("morph.fabrication.divide.divide", never)
    change(learned)
    capsys.readouterr()
    words = ["--printer", "mk4", "--material", "pla", "--slicer", "none", "--quiet"]
    given = ["print", robot, *words, "--policy", "out/policy", "--out", "package"]
    assert main(given) == 2
    said = capsys.readouterr().err
    assert says in said
    assert "fix:" in said
    assert not Path("package").exists()
