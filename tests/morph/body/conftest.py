"""A bench on which small descriptions are written, read and looked at."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import pytest

from morph.body.finding import DescriptionFinding
from morph.body.load import load
from morph.body.robot import Robot
from morph.errors import DescriptionRefused


@dataclass(frozen=True, kw_only=True)
class Reading:
    """What became of a description."""

    path: Path
    """The description."""
    robot: Robot | None
    """The robot; None if it was refused."""
    findings: tuple[DescriptionFinding, ...]
    """What was found."""

    def of(self, code: str) -> list[DescriptionFinding]:
        """Return the findings of a code."""
        return [finding for finding in self.findings if finding.code == code]

    def the(self, code: str) -> DescriptionFinding:
        """Return the only finding of a code."""
        (finding,) = self.of(code)
        return finding

    def line(self, text: str) -> int:
        """Return the only line of the description that holds a text, from 1."""
        lines = self.path.read_text().splitlines()
        (number,) = (at for at, line in enumerate(lines, 1) if text in line)
        return number

    def stands(self, code: str, severity: str, kind: str, name: str, text: str = "") -> bool:
        """Return whether a code is told once, so severely, of this part, at the line of a text."""
        where = [(f.severity, f.where.kind, f.where.name, f.where.line) for f in self.of(code)]
        line = self.line(text or f'<{kind} name="{name}"')
        told = all(
            f.what.strip() and f.fix.strip() and f.where.file == str(self.path)
            for f in self.of(code)
        )
        return told and where == [(severity, kind, name, line)]


class Bench:
    """Writes descriptions, one element a line, and reads them."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    @staticmethod
    def link(
        name: str,
        *shapes: str,
        mass: float | None = 1.0,
        moments: tuple[float, ...] = (0.01, 0.01, 0.01),
        com: str = "0 0 0",
    ) -> str:
        """Return a link with the moments xx, yy, zz and maybe xy, xz, yz; no mass: no inertial."""
        held = "".join(shapes)
        if mass is not None:
            keys = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
            values = (*moments, 0.0, 0.0, 0.0)[:6]
            inertia = " ".join(f'{k}="{v!r}"' for k, v in zip(keys, values, strict=True))
            held += f'<inertial><origin xyz="{com}"/><mass value="{mass!r}"/>'
            held += f"<inertia {inertia}/></inertial>"
        return f'<link name="{name}">{held}</link>'

    @staticmethod
    def joint(
        name: str,
        parent: str,
        child: str,
        kind: str = "continuous",
        *held: str,
        xyz: str = "0 0 0",
        axis: str = "0 0 1",
    ) -> str:
        """Return a joint, with more elements in it."""
        ends = f'<parent link="{parent}"/><child link="{child}"/>'
        frame = f'<origin xyz="{xyz}"/><axis xyz="{axis}"/>'
        return f'<joint name="{name}" type="{kind}">{ends}{frame}{"".join(held)}</joint>'

    @staticmethod
    def box(size: str = "0.2 0.2 0.2", xyz: str = "0 0 0", role: str = "visual") -> str:
        """Return a box as a shape of a link."""
        return f'<{role}><origin xyz="{xyz}"/><geometry><box size="{size}"/></geometry></{role}>'

    @staticmethod
    def mesh(file: str, xyz: str = "0 0 0", scale: str = "1 1 1", role: str = "visual") -> str:
        """Return a mesh as a shape of a link."""
        held = f'<mesh filename="{file}" scale="{scale}"/>'
        return f'<{role}><origin xyz="{xyz}"/><geometry>{held}</geometry></{role}>'

    def write(
        self, *elements: str, files: Mapping[str, bytes] | None = None, name: str = "robot.urdf"
    ) -> Path:
        """Write a robot of some elements, and the files beside it; return its path."""
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("\n".join(['<robot name="robot">', *elements, "</robot>"]))
        for file, content in (files or {}).items():
            (path.parent / file).parent.mkdir(parents=True, exist_ok=True)
            (path.parent / file).write_bytes(content)
        return path

    def read(
        self,
        *elements: str,
        files: Mapping[str, bytes] | None = None,
        name: str = "robot.urdf",
        base: str | None = "fixed",
    ) -> Reading:
        """Write a robot and read it."""
        return self.open(self.write(*elements, files=files, name=name), base=base)

    @staticmethod
    def open(path: Path, *, base: str | None = "fixed", folder: Path | None = None) -> Reading:
        """Read a description; only a refusal with findings is expected."""
        try:
            robot = load(path, base=base, folder=folder)
        except DescriptionRefused as error:
            return Reading(path=path, robot=None, findings=error.findings)
        return Reading(path=path, robot=robot, findings=robot.findings)


@pytest.fixture
def bench(tmp_path: Path) -> Bench:
    """A bench in a folder of its own."""
    return Bench(tmp_path / "bench")
