from __future__ import annotations

import re
import subprocess
import sys
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from morph.body.load import load
from morph.errors import TrialStopped
from morph.policy_transfer.live.live import Live
from morph.policy_transfer.live.process import Process
from morph.policy_transfer.live.protocol import hello_of, parsed
from morph.policy_transfer.live.serve import Serve
from morph.policy_transfer.live.watch import Watch
from morph.policy_transfer.live.wiring import Wiring
from morph.task.tasks import task

DOCS = Path(__file__).resolve().parents[2] / "docs"
BRIDGE = DOCS / "live_ros2.py"

ROS = {
    "rclpy/__init__.py": """
import threading, time
from rclpy import executors
_over = threading.Event()
def init(): pass
def shutdown(): _over.set()
def spin(node):
    # A cart of 1 kg under the last effort, in steps of 10 ms; timers as they are due.
    x = v = 0.0
    count, due = 0, {each: each[0] for each in node.timers}
    begun = time.monotonic()
    while not _over.is_set():
        now = time.monotonic() - begun
        while count * 0.01 <= now:
            v += 0.01 * node.effort; x += 0.01 * v; count += 1
        if not node.mute(count):
            node.seen(node.joint_state(x, v, 1000.0 + 0.01 * count, count))
        for each in due:
            if now >= due[each]:
                due[each] += each[0]; each[1]()
        time.sleep(0.002)
    raise executors.ExternalShutdownException
""",
    "rclpy/executors.py": "class ExternalShutdownException(Exception): pass\n",
    "rclpy/qos.py": "qos_profile_sensor_data = object()\n",
    "rclpy/node.py": """
import os
from types import SimpleNamespace as Plain
class Node:
    def __init__(self, name): self.timers, self.effort = [], 0.0
    def create_publisher(self, kind, topic, depth): return Plain(publish=self._published)
    def create_subscription(self, kind, topic, seen, qos): self.seen = seen
    def create_timer(self, period, call): self.timers.append((period, call))
    def _published(self, message): self.effort = message.data[0]
    def mute(self, count): return "MUTE" in os.environ and count > 60
    def joint_state(self, x, v, stamp, count):
        # Another order than the description's, and a joint more.
        sec = int(stamp); wobble = 1e-6 * (count % 7)
        return Plain(name=["wheel", "hinge", "slide"], position=[0.0, wobble, x + wobble],
            velocity=[0.0, -wobble, v + wobble],
            header=Plain(stamp=Plain(sec=sec, nanosec=round((stamp - sec) * 1e9))))
""",
    "sensor_msgs/msg.py": "class JointState: pass\n",
    "std_msgs/msg.py": "class Float64MultiArray: data = None\n",
}
"""What stands for ROS 2: as much of it as the bridge needs, and a cart."""


def blocks(page: Path) -> list[str]:
    text = page.read_text(encoding="utf-8")
    found = re.findall(r"^```python\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    assert len(found) == text.count("```python") >= 1
    return found


@pytest.mark.parametrize("name", ["live", "online"])
def test_the_python_of_a_page_runs_from_top_to_bottom(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    page = DOCS / f"{name}.md"
    names: dict[str, Any] = {"__name__": name}
    for block in blocks(page):
        exec(compile(block, str(page), "exec"), names)
    for value in list(names.values()):
        if isinstance(value, Live):
            value.close()
    # What a program leaves to its end is closed here: an open file would be a warning.
    for side in ("robot", "service"):
        if side in names and name == "online":
            names[side]._post.close()


@pytest.mark.parametrize("name", ["live", "online"])
def test_every_file_that_a_page_links_to_is_there(name: str) -> None:
    links = re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", (DOCS / f"{name}.md").read_text())
    assert links
    assert [link for link in links if not (DOCS / link).exists()] == []


def test_every_option_of_the_practice_target_is_explained() -> None:
    text = (DOCS / "live.md").read_text(encoding="utf-8")
    explained = set(re.findall(r"--([a-z]+)\b", text))
    assert {field.name for field in fields(Serve)} - explained == set()


def test_the_first_message_of_the_page_fits_the_cartpole() -> None:
    text = (DOCS / "live.md").read_text(encoding="utf-8")
    (said,) = re.findall(r"^```json\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    hello = hello_of(parsed(said.replace("\n", "").encode()) or {}, where="page")
    swing = task("swing-up", load("cartpole"))
    wiring = Wiring(swing.robot, swing.simulator().model, hello, period=0.05, where="page")
    assert wiring.unused == ()


def test_the_numbers_of_the_page_are_those_of_the_watch() -> None:
    text = (DOCS / "live.md").read_text(encoding="utf-8")
    watch = Watch()
    assert f"`Watch.answer_within`, {watch.answer_within:g} s" in text
    assert f"`begin_within`, {watch.begin_within:g} s" in text
    assert f"`Watch.start_within`, {watch.start_within:g} rad" in text
    assert f"`Watch.unreadable`, {watch.unreadable} a trial" in text
    assert (watch.repeats, watch.lost, watch.irregular) == (10, 0.5, 0.1)


@pytest.fixture
def ros(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    for name, text in ROS.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    return tmp_path


def test_the_bridge_to_ros_moves_a_cart_and_stops_it(ros: Path) -> None:
    swing = replace(task("swing-up", load("cartpole")), horizon=0.5)
    # On a busy machine the stand-in may be late by some milliseconds: that is not on trial.
    watch = Watch(lost=0.9)
    target = Live(swing, Process([sys.executable, str(BRIDGE)]), watch=watch)
    try:
        shown = target.trial(np.full((10, 1), 1.0), np.random.default_rng(0))
        # 1 N on 1 kg for 0.5 s, less at most two periods on its way.
        assert 0.38 < shown.velocity[-1, 0] - shown.velocity[0, 0] < 0.56
        assert target.conduct is not None
        assert target.conduct.safe
    finally:
        target.close()


def test_the_bridge_to_ros_says_when_joint_states_stop(
    ros: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MUTE", "1")
    swing = task("swing-up", load("cartpole"))
    target = Live(swing, Process([sys.executable, str(BRIDGE)]), watch=Watch(lost=0.9))
    with pytest.raises(TrialStopped, match=r"it says: 'no new joint states in a control period'"):
        target.trial(np.zeros((60, 1)), np.random.default_rng(0))
    target.close()


def test_the_bridge_to_ros_ends_when_morph_is_gone(ros: Path) -> None:
    run = subprocess.run(
        [sys.executable, str(BRIDGE)],
        input='{"begin": {}}\n{"command": {"slide": 1.0}}\n',
        capture_output=True,
        text=True,
        timeout=60.0,
        check=False,
    )
    assert (run.returncode, run.stderr) == (0, "")
