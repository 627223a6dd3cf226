"""Compare the robot you think you have with what your robot did.

`load` gives a robot, `world` what a floor or water does to it, `load_policy` what
commands it, `simulate` and `Simulator` let it move under effects,
`load_recordings` reads what a real one did, `compare` says where the two part,
`diagnose` what physics was left out, and `EFFECTS` lists the physics that it knows.
"""

from typing import Any

import lazy_loader

# Looked up on first use, so that `import morph` stays as light as an import of nothing.
_lazy, _, __all__ = lazy_loader.attach_stub(__name__, __file__)
__all__ += ["__version__"]


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version

        return version("morph-robotics")
    return _lazy(name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
