"""A URDF in its folder, read without any code of morph: the planter has to stand on its own."""

from __future__ import annotations

import shutil
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path, PurePosixPath


@dataclass(frozen=True, kw_only=True)
class Description:
    """One robot's description: a URDF and the meshes that it names, in a folder of their own."""

    name: str
    """What the study calls the robot."""
    root: Path
    """The folder that the description keeps to."""
    urdf: PurePosixPath
    """The URDF inside it."""

    @property
    def path(self) -> Path:
        """Return where the URDF stands."""
        return self.root / self.urdf

    @cached_property
    def robot(self) -> ET.Element:
        """Return the URDF's root element as it was when first asked for; not to be changed."""
        return self.parse()

    def parse(self) -> ET.Element:
        """Return the URDF's root element, read anew, with its comments, free to be changed."""
        parser = ET.XMLParser(target=ET.TreeBuilder(insert_comments=True))
        return ET.parse(self.path, parser).getroot()

    def write(self, robot: ET.Element) -> None:
        """Put a changed URDF in the place of the old one."""
        ET.ElementTree(robot).write(self.path, encoding="utf-8", xml_declaration=True)
        vars(self).pop("robot", None)
        vars(self).pop("parents", None)

    @cached_property
    def parents(self) -> dict[str, str]:
        """Return the joint that each link hangs from, by the link's name."""
        return {child_of(joint): named(joint) for joint in self.robot.findall("joint")}

    @property
    def links(self) -> list[str]:
        """Return the names of the links in the file's order."""
        return [named(link) for link in self.robot.findall("link")]

    @property
    def joints(self) -> list[str]:
        """Return the names of the joints in the file's order."""
        return [named(joint) for joint in self.robot.findall("joint")]

    @property
    def base(self) -> str:
        """Return the first link that hangs from none."""
        return next(link for link in self.links if link not in self.parents)

    def below(self, link: str) -> list[str]:
        """Return a link and all that hangs from it, parents before children."""
        order = [link]
        for at in order:
            order += [child_of(j) for j in self.robot.findall("joint") if parent_of(j) == at]
        return order

    def file_of(self, uri: str) -> Path | None:
        """Return the file of a mesh, capitals as they stand, or None if it is not there.

        A `package://` path is looked for with its first folders left out, one after
        another, from the folder of the URDF upward to the root.
        """
        return next((place for place in self._places(uri) if place.is_file()), None)

    def _places(self, uri: str) -> Iterator[Path]:
        """Yield where a mesh of this path may be, the likeliest place first."""
        parts = PurePosixPath(uri.split("://")[-1].lstrip("/")).parts
        folders = [self.path.parent, *self.path.parent.parents]
        folders = folders[: folders.index(self.root) + 1]
        for start in range(len(parts)):
            for folder in folders:
                yield folder.joinpath(*parts[start:])

    def meshes(self, link: str) -> list[str]:
        """Return the paths of a link's meshes as the URDF gives them, each once."""
        element = link_in(self.robot, link)
        return list(dict.fromkeys(mesh.get("filename", "") for mesh in element.iter("mesh")))

    def users(self, file: Path) -> list[str]:
        """Return the links with a shape from one mesh file."""
        return [
            link for link in self.links if any(self.file_of(m) == file for m in self.meshes(link))
        ]

    def files(self) -> Iterator[Path]:
        """Return the URDF and every mesh of it that is there, in whatever capitals, each once."""
        yield self.path
        small = {str(path).lower(): path for path in sorted(self.root.rglob("*")) if path.is_file()}
        uris = dict.fromkeys(mesh.get("filename", "") for mesh in self.robot.iter("mesh"))
        found = (
            self.file_of(uri)
            or next((small[p] for q in self._places(uri) if (p := str(q).lower()) in small), None)
            for uri in uris
        )
        yield from dict.fromkeys(file for file in found if file)

    def copy_to(self, folder: Path) -> Description:
        """Return the same description copied, byte for byte, into a folder of its own."""
        root = folder.resolve() / self.root.name
        for file in [*self.files(), *self.root.glob("package.xml")]:
            place = root / file.relative_to(self.root)
            place.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(file, place)
        return Description(name=self.name, root=root, urdf=self.urdf)


def named(element: ET.Element) -> str:
    """Return the name of a link or joint."""
    return element.get("name", "")


def link_in(robot: ET.Element, name: str) -> ET.Element:
    """Return a link by its name."""
    return next(link for link in robot.findall("link") if named(link) == name)


def joint_in(robot: ET.Element, name: str) -> ET.Element:
    """Return a joint by its name."""
    return next(joint for joint in robot.findall("joint") if named(joint) == name)


def parent_of(joint: ET.Element) -> str:
    """Return the link that a joint hangs from."""
    element = joint.find("parent")
    return "" if element is None else element.get("link", "")


def child_of(joint: ET.Element) -> str:
    """Return the link that a joint carries."""
    element = joint.find("child")
    return "" if element is None else element.get("link", "")


def numbers(element: ET.Element | None, attribute: str, default: str) -> list[float]:
    """Return the numbers of an attribute, or of the default where it is not given."""
    text = default if element is None else element.get(attribute, default)
    return [float(word) for word in text.split()]


def text_of(values: object) -> str:
    """Return numbers as an attribute holds them."""
    return " ".join(f"{value:.9g}" for value in values)  # type: ignore[attr-defined]
