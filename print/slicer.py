"""PrusaSlicer without a screen: a part, or a plate, becomes G-code, and the G-code is weighed."""

from __future__ import annotations

import os
import re
import shutil
import signal
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from print.arrays import Array
from print.attended import Ran, attended
from print.deposit import deposit
from print.errors import SlicerError
from print.gcode import lines
from print.job import Orientation
from print.mesh import Mesh
from print.part import Part
from print.printer import Profile
from print.settings import BRIM_MM, SKIRT_MM, SLIM, settings
from print.sliced import Sliced

PROGRAMS = ("prusa-slicer", "PrusaSlicer", "prusa-slicer-console")
"""Names under which PrusaSlicer is installed."""
INSTALL = "install PrusaSlicer (on Debian: apt-get install prusa-slicer), or go without: estimate"
TIME = re.compile(rb"^; estimated printing time \(normal mode\) = (.+)$", re.MULTILINE)
FILAMENT = re.compile(rb"^; filament used \[mm\] = ([0-9.]+)", re.MULTILINE)
END = b"; prusaslicer_config = end"
"""The last line of every G-code that PrusaSlicer finished."""
WARNING = re.compile(r"^(?:print|print_object) warning: (.+)$|^\[.*?\[(?:warning|error)\]\s*(.+)$")
AGREE = 0.005
"""Our sum of the filament and the slicer's own may differ by this part."""


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
        _agree(code.gcode, float(drawn.filament.sum()), part.name)
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
        _on_bed(meshes, profile)
        brim = BRIM_MM if any(_slim(mesh) for mesh in meshes.values()) else 0.0
        try:
            with tempfile.TemporaryDirectory(prefix="morph-slicer-") as name:
                return self._code(Path(name), meshes, profile, brim, timeout_s, where)
        except OSError as error:
            raise SlicerError(
                f"{self.name} cannot be run: {error.strerror or error}",
                where=where,
                fix=f"see that {self.program} can be run and that {tempfile.gettempdir()} has room",
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
        skirt = _room(meshes, profile) > SKIRT_MM + brim + 2.0 * profile.line_mm
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
        )
        _ended_well(ran, self.name, timeout_s, where)
        gcode = output.read_bytes() if output.is_file() else b""
        _whole(gcode, ran, self.name, where)
        return Code(gcode=gcode, seconds=_seconds(gcode), warnings=_warnings(ran.said))


def find_slicer() -> Slicer | None:
    """Return the PrusaSlicer on the path, or None where there is none that answers."""
    for name in PROGRAMS:
        found = shutil.which(name)
        if found is None:
            continue
        version = _version(Path(found))
        if version:
            return Slicer(program=Path(found), name=version)
    return None


def laid(mesh: Mesh, turn: Array, profile: Profile) -> Array:
    """Return the pose, shape (4, 4), mm, that lays a turned part on the middle of the bed."""
    pose = np.eye(4)
    pose[:3, :3] = turn
    low, high = mesh.moved(pose).bounds
    width, depth, _ = profile.printer.bed_mm
    pose[:3, 3] = np.array([width / 2.0, depth / 2.0, 0.0]) - [*((low + high) / 2.0)[:2], low[2]]
    return pose


def back(pose: Array) -> Array:
    """Return the pose that undoes one that neither stretches nor shears."""
    undone = np.eye(4)
    undone[:3, :3] = pose[:3, :3].T
    undone[:3, 3] = -pose[:3, :3].T @ pose[:3, 3]
    return undone


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
    found = re.search(r"PrusaSlicer-(\d+\.\d+\.\d+)", ran.said)
    return f"PrusaSlicer {found.group(1)}" if found and ran.status == 0 else ""


def _environment(folder: Path) -> dict[str, str]:
    """Return an environment without a screen, in which nothing of the user's is touched."""
    kept = {key: value for key, value in os.environ.items() if key in ("PATH", "LD_LIBRARY_PATH")}
    return {**kept, "HOME": str(folder), "TMPDIR": str(folder), "LC_ALL": "C"}


def mesh_of(part: Part) -> Mesh:
    """Return the mesh of a part.

    Raises:
        SlicerError: It has none.
    """
    if part.mesh is None:
        raise SlicerError(
            "it has no mesh", where=part.name, fix="slice only parts that are printed"
        )
    return part.mesh


def _on_bed(meshes: dict[str, Mesh], profile: Profile) -> None:
    """Refuse what is off the bed: PrusaSlicer without a screen prints it without a word."""
    bed = np.array(profile.printer.bed_mm)
    for name, mesh in meshes.items():
        low, high = mesh.bounds
        if (low < -0.01).any() or (high > bed + 0.01).any():
            size = " x ".join(f"{each:.1f}" for each in mesh.extent)
            raise SlicerError(
                f"it ({size} mm) lies from ({low[0]:.1f}, {low[1]:.1f}, {low[2]:.1f}) to "
                f"({high[0]:.1f}, {high[1]:.1f}, {high[2]:.1f}) mm, off the bed of "
                f"{profile.printer.title} ({bed[0]:g} x {bed[1]:g} x {bed[2]:g} mm)",
                where=name,
                fix="cut or turn the part so that it fits, or name a larger printer",
            )


def _room(meshes: dict[str, Mesh], profile: Profile) -> float:
    """Return the least distance from what is printed to an edge of the bed, mm."""
    low = np.min([mesh.bounds[0] for mesh in meshes.values()], axis=0)
    high = np.max([mesh.bounds[1] for mesh in meshes.values()], axis=0)
    return float(min(low[:2].min(), (np.array(profile.printer.bed_mm) - high)[:2].min()))


def _slim(mesh: Mesh) -> bool:
    """Return whether it stands too high to stand safely on its foot alone."""
    return bool(mesh.extent[2] > SLIM * mesh.extent[:2].min())


def _ended_well(ran: Ran, name: str, timeout_s: float, where: str) -> None:
    if ran.status is None:
        raise SlicerError(
            f"{name} did not end within {timeout_s:g} s and was killed; it said: {_last(ran)}",
            where=where,
            fix="give it more time, reduce the mesh, or go without the slicer",
        )
    if ran.status < 0:
        raise SlicerError(
            f"{name} died of {_signal(-ran.status)}; it said: {_last(ran)}",
            where=where,
            fix="see that there is enough memory and that the mesh is a clean solid",
        )
    if ran.status > 0:
        raise SlicerError(
            f"{name} ended with status {ran.status}; it said: {_last(ran)}",
            where=where,
            fix="put right what it complains of, or go without the slicer",
        )


def _whole(gcode: bytes, ran: Ran, name: str, where: str) -> None:
    if gcode and END in gcode[-200:] and FILAMENT.search(gcode):
        return
    found = f"{len(gcode)} bytes without the end of a G-code" if gcode else "no G-code"
    raise SlicerError(
        f"{name} ended as if all were well but wrote {found}; it said: {_last(ran)}",
        where=where,
        fix=f"see that {tempfile.gettempdir()} has room, and slice the part by hand to look at it",
    )


def _agree(gcode: bytes, ours: float, where: str) -> None:
    """Refuse a G-code of which our sum of the filament is not the slicer's."""
    found = FILAMENT.search(gcode)
    theirs = float(found.group(1)) if found else 0.0
    if abs(ours - theirs) > AGREE * theirs:
        raise SlicerError(
            f"its lines use {ours:.1f} mm of filament, while its last lines say {theirs:.1f} mm",
            where=f"G-code of {where}",
            fix="slice the part again; should it stay, report the version of the slicer",
        )


def _signal(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:
        return f"signal {number}"


def _last(ran: Ran) -> str:
    """Return the last lines that a slicer said, without its progress."""
    said = [line for line in ran.said.splitlines() if line.strip() and "] [trace]" not in line]
    return " | ".join(line.strip()[:200] for line in said[-4:]) or "nothing"


def _seconds(gcode: bytes) -> float:
    """Return the slicer's estimate of the time, such as `1d 2h 3m 4s`, in seconds."""
    found = TIME.search(gcode)
    units = {"d": 86400.0, "h": 3600.0, "m": 60.0, "s": 1.0}
    text = found.group(1).decode() if found else ""
    return sum(float(count) * units[unit] for count, unit in re.findall(r"(\d+)([dhms])", text))


def _warnings(said: str) -> tuple[str, ...]:
    """Return what a slicer warned of, each warning once."""
    found = (WARNING.match(line.strip()) for line in said.splitlines())
    return tuple(dict.fromkeys((each.group(1) or each.group(2)) for each in found if each))
