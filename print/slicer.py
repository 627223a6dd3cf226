"""PrusaSlicer without a screen: a part, or a plate, becomes G-code, and the G-code is weighed."""

from __future__ import annotations

import os
import re
import shutil
import tempfile
import threading
from dataclasses import dataclass, field
from pathlib import Path

from morph.print.bed_pose import back, edge_room, laid, mesh_of, on_bed, slim
from morph.print.deposit import deposit
from morph.print.errors import SlicerError
from morph.print.gcode import lines
from morph.print.job import Orientation
from morph.print.mesh import Mesh
from morph.print.outcome import agree, ended_well, seconds, warnings, whole
from morph.print.part import Part
from morph.print.printer import Profile
from morph.print.run_with_timeout import attended
from morph.print.settings import BRIM_MM, SKIRT_MM, settings
from morph.print.sliced import Sliced

PROGRAMS = ("prusa-slicer", "PrusaSlicer", "prusa-slicer-console")
"""Names under which PrusaSlicer is installed."""
INSTALL = "install PrusaSlicer (on Debian: apt-get install prusa-slicer), or go without: estimate"


@dataclass(frozen=True, kw_only=True, eq=False)
class Code:
    """A G-code, and what the slicer says of it."""

    gcode: bytes
    """Its text."""
    seconds: float
    """How long the slicer expects the printer to take."""
    warnings: tuple[str, ...]
    """What the slicer warned of, in its words."""


@dataclass(frozen=True, kw_only=True)
class Slicer:
    """A PrusaSlicer on this machine."""

    program: Path
    """Its executable."""
    name: str
    """Its name and version, such as `PrusaSlicer 2.5.0`."""
    stop: threading.Event = field(default_factory=threading.Event, compare=False, repr=False)
    """Once set, what is being sliced in any thread is killed, and nothing more is sliced."""

    def sliced(
        self, part: Part, orientation: Orientation, profile: Profile, *, timeout_s: float = 300.0
    ) -> Sliced:
        """Return how one copy of a part comes off the printer.

        Raises:
            SlicerError: The slicer is missing, hangs, dies, or writes what cannot be used.
        """
        mesh = mesh_of(part)
        pose = laid(mesh, orientation.turn, profile)
        code = self.code({part.name: mesh.moved(pose)}, profile, timeout_s=timeout_s)
        drawn = lines(code.gcode, where=f"G-code of {part.name}")
        agree(code.gcode, float(drawn.filament.sum()), part.name)
        left = deposit(drawn, profile)
        return Sliced(
            source="gcode",
            weight=left.weight.moved(back(pose)),
            support_kg=left.away,
            seconds=code.seconds,
            by_feature=left.by_feature,
            warnings=code.warnings,
            gcode=code.gcode,
            slicer=self.name,
        )

    def code(self, meshes: dict[str, Mesh], profile: Profile, *, timeout_s: float = 300.0) -> Code:
        """Return the G-code of meshes as they lie on the bed, whose corner is the origin.

        Args:
            meshes: What is printed at once, by the names that the G-code shall give it.
            profile: Printer, material and settings.
            timeout_s: Seconds that the slicer may take.

        Raises:
            SlicerError: Something is off the bed, or the slicer is missing, hangs, dies, or
                writes what cannot be used.
        """
        where = ", ".join(list(meshes)[:3]) + (" ..." if len(meshes) > 3 else "")
        if shutil.which(self.program) is None:
            raise SlicerError(f"{self.program} is no program", where=where, fix=INSTALL)
        on_bed(meshes, profile)
        brim = BRIM_MM if any(slim(mesh) for mesh in meshes.values()) else 0.0
        try:
            with tempfile.TemporaryDirectory(prefix="morph-slicer-") as name:
                return self._code(Path(name), meshes, profile, brim, timeout_s, where)
        except OSError as error:
            raise SlicerError(
                f"{self.name} cannot be run in {tempfile.gettempdir()}: {error.strerror or error}",
                where=where,
                fix="make room there, or name another folder by TMPDIR",
            ) from error

    def _code(
        self,
        folder: Path,
        meshes: dict[str, Mesh],
        profile: Profile,
        brim: float,
        timeout_s: float,
        where: str,
    ) -> Code:
        skirt = edge_room(meshes, profile) > SKIRT_MM + brim + 2.0 * profile.line_mm
        config, output = folder / "profile.ini", folder / "out.gcode"
        config.write_text(settings(profile, brim_mm=brim, skirt=skirt))
        inputs = [folder / f"{name}.stl" for name in meshes]
        for path, mesh in zip(inputs, meshes.values(), strict=True):
            path.write_bytes(mesh.trimesh.export(file_type="stl"))
        ran = attended(
            [
                *(str(self.program), "--datadir", str(folder / "data"), "--loglevel", "2"),
                *("--load", str(config), "--export-gcode", "--output", str(output)),
                *("--dont-arrange", "--merge", *map(str, inputs)),
            ],
            folder=folder,
            environment=_environment(folder),
            timeout_s=timeout_s,
            stop=self.stop,
        )
        if self.stop.is_set():
            raise SlicerError("slicing was stopped", where=where, fix="start it again")
        ended_well(ran, self.name, timeout_s, where)
        gcode = output.read_bytes() if output.is_file() else b""
        whole(gcode, ran, self.name, where)
        return Code(gcode=gcode, seconds=seconds(gcode), warnings=warnings(ran.said))


def find_slicer() -> Slicer | None:
    """Return the PrusaSlicer on the path, or None where there is none that answers."""
    for name in PROGRAMS:
        result = shutil.which(name)
        if result is None:
            continue
        version = _version(Path(result))
        if version:
            return Slicer(program=Path(result), name=version)
    return None


def _version(program: Path) -> str:
    with tempfile.TemporaryDirectory(prefix="morph-slicer-") as name:
        folder = Path(name)
        try:
            ran = attended(
                [str(program), "--datadir", str(folder / "data"), "--help"],
                folder=folder,
                environment=_environment(folder),
                timeout_s=20.0,
            )
        except OSError:
            return ""
    result = re.search(r"PrusaSlicer-(\d+\.\d+\.\d+)", ran.said)
    return f"PrusaSlicer {result.group(1)}" if result and ran.status == 0 else ""


def _environment(folder: Path) -> dict[str, str]:
    """Return an environment without a screen, in which nothing of the user's is touched."""
    kept = {key: value for key, value in os.environ.items() if key in ("PATH", "LD_LIBRARY_PATH")}
    return {**kept, "HOME": str(folder), "TMPDIR": str(folder), "LC_ALL": "C"}
