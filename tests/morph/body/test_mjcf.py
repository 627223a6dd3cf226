from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

from morph.body.finding import DescriptionFinding
from morph.body.load import load
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.errors import DescriptionRefused

INERTIAL = "<inertial pos='0 0 0' mass='2' diaginertia='1 1 1'/>"
BODY = f"<body name='a'><joint name='j'/>{INERTIAL}{{}}</body>"


def mjcf(folder: Path, body: str = BODY, *, top: str = "", name: str = "robot.xml") -> Path:
    """Write an MJCF of one body, with elements before it."""
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"<mujoco model='m'>\n{top}\n<worldbody>\n{body}\n</worldbody>\n</mujoco>")
    return path


def codes(robot: Robot) -> list[tuple[str, str]]:
    return [(each.severity, each.code) for each in robot.findings if each.severity != "info"]


def refusal(path: Path) -> DescriptionFinding:
    """Return the one finding of severity `refused`."""
    with pytest.raises(DescriptionRefused) as refused:
        load(path)
    (found,) = [each for each in refused.value.findings if each.severity == "refused"]
    return found


def test_a_broken_inertia_is_mended_and_told(tmp_path: Path) -> None:
    body = "<body name='a'><joint/><inertial pos='0 0 0' mass='1' diaginertia='1 1 3'/></body>"
    path = mjcf(tmp_path, body)
    with pytest.raises(ValueError, match="A \\+ B >= C"):
        mujoco.MjModel.from_xml_path(str(path))
    robot = load(path)
    assert codes(robot) == [("repaired", "inertia-broken")]
    moments = np.sort(robot.links[0].inertia[:3])
    assert moments[0] + moments[1] >= moments[2]
    # The nearest: second moments (1.5, 1.5, -0.5) with the last raised to about nothing.
    assert moments == pytest.approx([1.5, 1.5, 3.0], abs=1e-3)


def test_a_name_that_two_bear_is_refused_by_its_code(tmp_path: Path) -> None:
    found = refusal(mjcf(tmp_path, BODY.format("") + BODY.format("")))
    assert found.code == "duplicate-name"


def test_defaults_are_as_mujoco_reads_them(tmp_path: Path) -> None:
    top = (
        "<compiler angle='radian'/><default><joint damping='0.5' range='-1 1'/>"
        "<geom density='500'/><default class='strong'><motor ctrlrange='-3 3'/>"
        "<joint damping='2'/></default></default>"
    )
    body = (
        "<body name='a' childclass='strong'><joint name='j'/><geom size='0.1'/>"
        "<body name='b'><joint name='k' class='main'/><geom size='0.1'/></body></body>"
    )
    path = mjcf(tmp_path, body, top=top)
    robot, direct = load(path), mujoco.MjModel.from_xml_path(str(path))
    model = spec_of(robot).compile()
    assert np.array_equal(model.dof_damping, direct.dof_damping)
    assert np.array_equal(model.body_mass, direct.body_mass)
    assert [joint.limits for joint in robot.joints] == [(-1.0, 1.0), (-1.0, 1.0)]


def test_infinite_limits_are_no_limits(tmp_path: Path) -> None:
    body = f"<body name='a'><joint name='j' range='-inf inf'/>{INERTIAL}</body>"
    path = mjcf(tmp_path, body, top="<default><joint range='-1 1'/></default>")
    robot = load(path)
    assert codes(robot) == [("repaired", "limit-absurd")]
    (found,) = robot.findings
    assert (found.where.kind, found.where.name, found.where.line) == ("joint", "j", 4)
    assert robot.joint("j").limits is None


def test_a_link_may_be_called_nan(tmp_path: Path) -> None:
    top = "<actuator><motor joint='inf'/></actuator>"
    body = f"<body name='nan'><joint name='inf'/>{INERTIAL}</body>"
    robot = load(mjcf(tmp_path, body, top=top))
    assert (robot.links[0].name, robot.actuators[0].joint) == ("nan", "inf")


@pytest.mark.parametrize(
    "body",
    [
        "<body name='a' pos='0 0 nan'/>",
        "<body name='a'><geom size='inf'/></body>",
        "<body name='a'><geom size='1' mass='1e400'/></body>",
    ],
)
def test_a_number_that_is_none_is_refused_at_its_line(body: str, tmp_path: Path) -> None:
    found = refusal(mjcf(tmp_path, body))
    assert (found.code, found.where.line) == ("ill-typed", 4)


def test_an_mjcf_without_a_body_is_refused(tmp_path: Path) -> None:
    assert "holds no body" in refusal(mjcf(tmp_path, "<geom size='1'/>")).what


def test_a_base_that_an_mjcf_does_not_have_is_refused(tmp_path: Path) -> None:
    path = mjcf(tmp_path, BODY.format(""))
    assert load(path, base="fixed").joints[0].name == "j"
    with pytest.raises(DescriptionRefused, match="says itself how its base stands: fixed"):
        load(path, base="floating")


def test_where_each_inertia_comes_from_is_known(tmp_path: Path) -> None:
    body = BODY.format("<body name='shaped'><joint/><geom size='1'/><body name='bare'/></body>")
    robot = load(mjcf(tmp_path, body))
    assert {link.name: link.inertia_from for link in robot.links} == {
        "a": "description",
        "shaped": "mesh x density",
        "bare": "none",
    }


def test_a_joint_that_follows_is_known_from_zero_and_not_from_home(tmp_path: Path) -> None:
    body = (
        "<body name='a'><joint name='j' ref='0.5'/><geom size='1'/></body>"
        "<body name='b'><joint name='k' ref='0.25'/><geom size='1'/></body>"
    )
    top = (
        "<compiler angle='radian'/><equality><joint joint1='j' joint2='k' polycoef='0.1 2 0 0 0'/>"
    )
    robot = load(mjcf(tmp_path, body, top=top + "</equality>"))
    mimic = robot.joint("j").mimic
    assert mimic is not None
    assert (mimic.joint, mimic.ratio) == ("k", 2.0)
    # j - 0.5 = 0.1 + 2 (k - 0.25)
    assert mimic.offset == pytest.approx(0.1)
    assert robot.joint("k").mimic is None


@pytest.mark.parametrize("mass", [2e7, 6e6])
def test_a_weight_that_no_robot_has_is_refused(mass: float, tmp_path: Path) -> None:
    # One link alone is too heavy at 2e7 kg, two together at 2 * 6e6 = 1.2e7 kg.
    inertial = f"<inertial pos='0 0 0' mass='{mass}' diaginertia='1 1 1'/>"
    bodies = (f"<body name='{name}'><joint/>{inertial}</body>" for name in "ab")
    found = refusal(mjcf(tmp_path, "".join(bodies)))
    assert found.code == "engine-refused"
    assert "kg, which no robot does" in found.what
    assert ("the link 'a'" in found.what) == (mass > 1e7)


@pytest.mark.parametrize("error", [RuntimeError("Caught an unknown exception!"), MemoryError()])
def test_what_mujoco_throws_without_words_is_a_refusal(
    error: Exception, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise error

    monkeypatch.setattr("morph.body.mjcf.spec_of", fail)
    found = refusal(mjcf(tmp_path, BODY.format("")))
    assert found.code == "engine-refused"
    assert (str(error) or "MemoryError") in found.what
