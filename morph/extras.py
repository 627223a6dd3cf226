"""Optional dependencies: the extra of the distribution that installs each package."""

from __future__ import annotations

from importlib.util import find_spec

from morph.errors import MissingPackage

DISTRIBUTION = "morph-robotics"
"""Name on the package index; `morph` itself is another project there."""

EXTRAS = {
    "learn": ("cmaes", "gymnasium", "onnx", "ot", "sklearn", "torch"),
    "view": ("fast_simplification", "imageio_ffmpeg", "PIL", "viser", "websockets", "zstandard"),
    "print": ("fast_simplification", "lib3mf", "manifold3d", "onnx"),
    "check": ("pinocchio",),
    "notebook": ("pandas",),
    "step": ("cascadio",),
    "cluster": ("dask", "distributed", "submitit"),
    "compiler": ("ziglang",),
}
"""Packages that each extra adds, by the name under which they are imported."""


def install_command(extra: str) -> str:
    """Return the command that installs an extra, for a shell."""
    return f"pip install '{DISTRIBUTION}[{extra}]'"


def extra_of(module: str) -> str | None:
    """Return the first extra that installs a module's package; None for all other modules."""
    top = module.partition(".")[0]
    return next((extra for extra, packages in EXTRAS.items() if top in packages), None)


def require(extra: str, command: str) -> None:
    """Check that the packages of an extra are installed, without importing them.

    Args:
        extra: A key of `EXTRAS`.
        command: What needs them, for the message, as `morph learn`.

    Raises:
        MissingPackage: One of them is not installed.
    """
    missing = [package for package in EXTRAS[extra] if find_spec(package) is None]
    if missing:
        raise MissingPackage(
            f"this needs {', '.join(missing)}, not installed here",
            where=command,
            fix=install_command(extra),
        )
