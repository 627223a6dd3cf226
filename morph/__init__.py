"""Compare the robot you think you have with what your robot did.

`load` gives a robot, `world` what a floor or water does to it, `load_policy` what
commands it, `simulate` and `Simulator` let it move under effects,
`load_recordings` (also `record.load`) reads what a real one did, `diagnose` says
where the two part and what physics was left out, and `EFFECTS` lists the physics
that it knows.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from morph import record as record
    from morph.body.load import load as load
    from morph.inference.diagnose import diagnose as diagnose
    from morph.physics import EFFECTS as EFFECTS
    from morph.physics.worlds import world as world
    from morph.policy.store import load_policy as load_policy
    from morph.record.load import load as load_recordings
    from morph.record.recording import Channel as Channel
    from morph.record.recording import Recording as Recording
    from morph.sim.simulate import simulate as simulate
    from morph.sim.simulator import Simulator as Simulator

    __version__: str

__all__ = [
    "EFFECTS",
    "Channel",
    "Recording",
    "Simulator",
    "__version__",
    "diagnose",
    "load",
    "load_policy",
    "load_recordings",
    "record",
    "simulate",
    "world",
]

# Looked up on first use, so that `import morph` stays as light as an import of nothing.
_HOMES = {
    "Channel": ("morph.record.recording", "Channel"),
    "EFFECTS": ("morph.physics", "EFFECTS"),
    "Recording": ("morph.record.recording", "Recording"),
    "Simulator": ("morph.sim.simulator", "Simulator"),
    "diagnose": ("morph.inference.diagnose", "diagnose"),
    "load": ("morph.body.load", "load"),
    "load_policy": ("morph.policy.store", "load_policy"),
    "load_recordings": ("morph.record.load", "load"),
    "simulate": ("morph.sim.simulate", "simulate"),
    "world": ("morph.physics.worlds", "world"),
}


def __getattr__(name: str) -> Any:
    if name == "__version__":
        return importlib.import_module("importlib.metadata").version("morph-robotics")
    if name == "record":
        return importlib.import_module("morph.record")
    if name not in _HOMES:
        raise AttributeError(f"module 'morph' has no attribute {name!r}")
    module, attribute = _HOMES[name]
    return getattr(importlib.import_module(module), attribute)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
