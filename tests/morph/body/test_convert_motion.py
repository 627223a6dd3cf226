from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pinocchio
import pytest
import yourdfpy
from scipy.spatial.transform import Rotation

from morph.arrays import Array
from morph.body import shelf
from morph.body.convert import FORMATS, convert
from morph.body.load import load
from morph.body.robot import Robot
from morph.body.spec import bare_spec

BODIES = tuple(name for name in shelf.names() if shelf.find(name).parent == shelf.builtin_shelf())

# Numbers are written with 17 digits, so each comes back as the same double; a link between two
# joints on one body weighs 1e-12 kg, and flat inertias are thickened by 1e-11 of themselves.
CLOSE = 1e-9


def original(robot: Robot) -> Any:
    """Return what MuJoCo reads in a body's own MJCF; of a URDF, what morph made of it."""
    if robot.source is not None and robot.source.suffix == ".xml":
        return mujoco.MjModel.from_xml_path(str(robot.source))
    return bare_spec(robot).compile()


def masses(path: Path) -> dict[str, float]:
    """Return the mass that each reader finds in a description."""
    found = {"mujoco": float(mujoco.MjModel.from_xml_path(str(path)).body_mass.sum())}
    if path.suffix == ".xml":
        twin = pinocchio.buildModelFromMJCF(str(path))
    else:
        twin = pinocchio.buildModelFromUrdf(str(path))
        links = yourdfpy.URDF.load(str(path)).robot.links
        found["yourdfpy"] = sum(link.inertial.mass for link in links if link.inertial is not None)
    found["pinocchio"] = sum(inertia.mass for inertia in twin.inertias)
    return found


class Pair:
    """A body and what was written of it, in poses that are the same."""

    def __init__(self, before: Any, after: Any) -> None:
        self.before, self.after = before, after
        self.data = mujoco.MjData(before), mujoco.MjData(after)
        self.balls = [j for j in range(before.njnt) if before.jnt_type[j] == 1]

    def pose(self, rng: np.random.Generator | None) -> None:
        """Put both into a random pose, or home."""
        one, other = self.data
        mujoco.mj_resetData(self.before, one)
        mujoco.mj_resetData(self.after, other)
        if rng is not None:
            for joint in range(self.before.njnt):
                self._turn(joint, rng)
        mujoco.mj_forward(self.before, one)
        mujoco.mj_forward(self.after, other)

    def _turn(self, joint: int, rng: np.random.Generator) -> None:
        name, kind = self.before.joint(joint).name, int(self.before.jnt_type[joint])
        mine = self.data[0].qpos[self.before.jnt_qposadr[joint] :]
        if kind == 1 and not _has(self.after, name):
            # Hinges about x, y and z in a row: q = q_x q_y q_z.
            turns = rng.normal(size=3)
            x, y, z, w = Rotation.from_euler("XYZ", turns).as_quat()
            mine[:4] = w, x, y, z
            for letter, turn in zip("xyz", turns, strict=True):
                self.data[1].joint(f"{name}_about_{letter}").qpos[:] = turn
            return
        theirs = self.data[1].joint(name).qpos
        if kind in (0, 1):
            turned = rng.normal(size=4)
            given = [*rng.normal(size=3 if kind == 0 else 0), *turned / np.linalg.norm(turned)]
            mine[: len(given)] = theirs[:] = given
            return
        # URDF is at zero where the body is at home.
        by = rng.normal()
        mine[0] += by
        theirs[:] += by

    def places(self) -> float:
        """Return how far apart the centre of any link with mass is, m."""
        names = [
            self.before.body(body).name
            for body in range(1, self.before.nbody)
            if self.before.body_mass[body] > 0
        ]
        one, other = self.data
        return max(np.abs(one.body(name).xipos - other.body(name).xipos).max() for name in names)

    def inertias(self) -> float:
        """Return how much the joint-space inertias differ, of the greatest entry."""
        order = [
            int(self.after.jnt_dofadr[self.after.joint(self._name(dof)).id])
            + dof
            - int(self.before.jnt_dofadr[self.before.dof_jntid[dof]])
            for dof in range(self.before.nv)
        ]
        one, other = (self._inertia(*each) for each in zip(self._models(), self.data, strict=True))
        return float(np.abs(one - other[np.ix_(order, order)]).max() / np.abs(one).max())

    def _models(self) -> tuple[Any, Any]:
        return self.before, self.after

    def _name(self, dof: int) -> str:
        return str(self.before.joint(int(self.before.dof_jntid[dof])).name)

    @staticmethod
    def _inertia(model: Any, data: Any) -> Array:
        full = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, full)
        return full - np.diag(model.dof_armature)  # URDF knows no rotors.


def _has(model: Any, joint: str) -> bool:
    return mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, joint) >= 0


def written(robot: Robot, to: str, folder: Path) -> Path:
    return convert(robot, to, folder).files[0]


def check_written(robot: Robot, path: Path) -> None:
    """Compare what was written with the original: mass, place of every link, inertia."""
    before = original(robot)
    for reader, mass in masses(path).items():
        assert mass == pytest.approx(robot.mass, rel=CLOSE), reader
    pair = Pair(before, mujoco.MjModel.from_xml_path(str(path)))
    rng = np.random.default_rng(5)
    for pose in (None, rng, rng):
        pair.pose(pose)
        assert pair.places() < CLOSE
        if before.nv and not (pair.balls and path.suffix == ".urdf"):
            assert pair.inertias() < CLOSE


@pytest.mark.parametrize("to", FORMATS)
@pytest.mark.parametrize("name", BODIES)
def test_every_reader_finds_the_same_body_in_what_was_written(
    name: str, to: str, tmp_path: Path
) -> None:
    robot = load(name)
    check_written(robot, written(robot, to, tmp_path / "out"))


@pytest.mark.parametrize(
    "file",
    [
        "poppy_humanoid/robots/Poppy_Humanoid.URDF",
        "erd_bolt/robots/bolt.urdf",
        "sigmaban/robot.urdf",
        "open_duck_mini_v2/mjcf/scene_rough_terrain_backlash.xml",
        "urdf_corpus/matlab__movo_description__urdf__kinovaMovo.urdf",
    ],
    ids=lambda file: file.split("/")[0],
)
def test_real_robots_keep_their_mass_and_their_motion(
    file: str, real_robots: Path, tmp_path: Path
) -> None:
    robot = load(real_robots / file)
    for to in FORMATS:
        path = written(robot, to, tmp_path / "out")
        for reader, mass in masses(path).items():
            assert mass == pytest.approx(robot.mass, rel=CLOSE), reader
        pair = Pair(bare_spec(robot).compile(), mujoco.MjModel.from_xml_path(str(path)))
        rng = np.random.default_rng(5)
        for pose in (None, rng):
            pair.pose(pose)
            assert pair.places() < CLOSE
            assert pair.inertias() < CLOSE


def test_links_that_are_made_up_take_no_name_that_there_is(tmp_path: Path) -> None:
    # A body with two joints becomes two links; the name of the second is already taken.
    body = (
        "<mujoco><worldbody><body name='arm'><joint name='a' axis='1 0 0'/>"
        "<joint name='b' axis='0 1 0' pos='0 0 1'/><geom size='1' mass='1'/><body name='arm_1'>"
        "<joint name='arm is fixed'/><geom size='1' mass='1'/></body></body></worldbody></mujoco>"
    )
    (tmp_path / "robot.xml").write_text(body)
    robot = load(tmp_path / "robot.xml")
    check_written(robot, written(robot, "urdf", tmp_path / "out"))


def test_a_home_away_from_zero_becomes_zero(tmp_path: Path) -> None:
    (tmp_path / "robot.xml").write_text(
        "<mujoco><compiler angle='radian'/><worldbody><body name='arm'><joint name='a' axis='0 1 0'"
        " ref='0.5' range='0 2'/><geom type='box' size='1 2 3' pos='4 0 0'/></body></worldbody>"
        "</mujoco>"
    )
    robot = load(tmp_path / "robot.xml")
    conversion = convert(robot, "urdf", tmp_path / "out")
    check_written(robot, conversion.files[0])
    model = mujoco.MjModel.from_xml_path(str(conversion.files[0]))
    assert model.joint("a").range.tolist() == [-0.5, 1.5]
    assert any("'a' stands at 0.5 at home" in left for left in conversion.left_out)
