"""The good descriptions to plant in: what is there of those that others published."""

from __future__ import annotations

import sysconfig
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path, PurePosixPath

from experiments.plant.description import Description
from experiments.public.manifest import data_root

PUBLISHED = {
    "aqua": ("aqua/aqua_description", "urdf/aqua.urdf"),
    "bolt": ("erd_bolt", "robots/bolt.urdf"),
    "double_pendulum": ("erd_double_pendulum", "urdf/double_pendulum.urdf"),
    "open_duck": ("open_duck_mini_v2/urdf", "robot.urdf"),
    "poppy_humanoid": ("poppy_humanoid", "robots/Poppy_Humanoid.URDF"),
    "sigmaban": ("sigmaban", "robot.urdf"),
    "solo8": ("solo", "resources/solo8.urdf"),
}
"""Folder and URDF of each robot below `robots_root`."""
PACKAGED = {
    "alexander": ("alexander_description", "urdf/alexander_v1.lowerBodyOnly.urdf"),
    "allegro": ("allegro_hand_description", "urdf/allegro_left_hand.urdf"),
    "finger_edu": ("finger_edu_description", "robots/finger_edu.urdf"),
    "go2": ("go2_description", "urdf/go2.urdf"),
    "hyq": ("hyq_description", "robots/hyq_no_sensors.urdf"),
    "icub": ("icub_description", "robots/icub.urdf"),
    "kinova": ("kinova_description", "robots/kinova.urdf"),
    "laikago": ("laikago_description", "urdf/laikago.urdf"),
    "so100": ("so_arm_description", "urdf/so100.urdf"),
    "solo12": ("solo_description", "robots/solo12.urdf"),
    "talos": ("talos_data", "robots/talos_reduced.urdf"),
    "xarm7": ("xarm_description", "urdf/xarm7.urdf"),
}
"""Folder and URDF of each robot in the data of PyPI's `example-robot-data`."""


def robots_root() -> Path:
    """Return the folder of real descriptions: that of `experiments.public.manifest`."""
    return data_root("robots").resolve()


def packaged_root() -> Path:
    """Return where `example-robot-data` keeps its robots in this environment."""
    below = Path("cmeel.prefix", "share", "example-robot-data", "robots")
    try:
        return Path(str(distribution("example-robot-data").locate_file(below)))
    except PackageNotFoundError:
        return Path(sysconfig.get_paths()["purelib"]) / below


def originals() -> list[Description]:
    """Return the descriptions that are on this machine, in the order of their names."""
    return sorted(
        (
            Description(name=name, root=root / folder, urdf=PurePosixPath(urdf))
            for root, table in ((robots_root(), PUBLISHED), (packaged_root(), PACKAGED))
            for name, (folder, urdf) in table.items()
            if (root / folder / urdf).is_file()
        ),
        key=lambda description: description.name,
    )
