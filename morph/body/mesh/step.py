"""Reading STEP, through the extra `step`."""

from __future__ import annotations

import importlib.util
import io
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from morph.body.mesh.limits import unreadable
from morph.body.mesh.solid import Mesh
from morph.extras import install_command

SECONDS = 120
"""Longest that the conversion may take."""

MEMORY = 4 * 2**30
"""Most address space that the conversion may take, bytes."""

CONVERT = """
import resource, sys
resource.setrlimit(resource.RLIMIT_AS, ({memory}, {memory}))
import cascadio
cascadio.step_to_glb(sys.argv[1], sys.argv[2], 0.01, 0.5)
"""
"""Run in a process of its own, for a native parser may crash on bad bytes.

Chords are at most 0.01 mm from the surface, and turn by 0.5 rad at most.
"""


def read_step(content: bytes, where: str) -> Mesh:
    """Return the solids in a STEP file, cut into triangles, in metres.

    Raises:
        MeshError: The extra is not installed, or the file cannot be converted.
    """
    if importlib.util.find_spec("cascadio") is None:
        raise unreadable(
            "reading STEP needs cascadio, which is not installed",
            where,
            f"{install_command('step')}; or export it as STL",
        )
    if not content.lstrip()[:12] == b"ISO-10303-21":
        raise unreadable("does not begin as STEP does, with ISO-10303-21", where)
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder, "part.step"), Path(folder, "part.glb")
        source.write_bytes(content)
        _convert(source, target, where)
        return _from_glb(target.read_bytes(), where)


def _convert(source: Path, target: Path, where: str) -> None:
    script = CONVERT.format(memory=MEMORY)
    command = [sys.executable, "-I", "-c", script, str(source), str(target)]
    try:
        ended = subprocess.run(command, capture_output=True, timeout=SECONDS, check=False)
    except subprocess.TimeoutExpired as error:
        raise unreadable(f"takes longer than {SECONDS} s to convert", where) from error
    if ended.returncode != 0 or not target.is_file():
        words = ended.stderr.decode(errors="replace").split("\n")[-2:][0][:200]
        raise unreadable(
            f"cannot be converted; cascadio ended with status {ended.returncode} {words}".rstrip(),
            where,
        )


def _from_glb(content: bytes, where: str) -> Mesh:
    # trimesh takes 0.2 s to import, and only STEP needs it.
    import trimesh

    scene = trimesh.load_scene(io.BytesIO(content), file_type="glb", process=False)
    if not scene.geometry:
        raise unreadable("holds no solid or surface", where)
    whole = scene.to_mesh()
    return Mesh(
        vertices=np.asarray(whole.vertices, dtype=np.float64),
        faces=np.asarray(whole.faces, dtype=np.int64),
    )
