"""Every code that a finding can have is raised by a least description, or it is said why not."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from morph.body.finding import CODES, DescriptionFinding, Where
from morph.body.inspect import inspect_robot

LIMIT = '<limit lower="{}" upper="{}" effort="1" velocity="{}"/>'
CUBE = trimesh.creation.box((0.2, 0.2, 0.2))
RING = bytes(trimesh.creation.annulus(r_min=0.2, r_max=0.22, height=0.1).export(file_type="stl"))
COLLISION = '<collision><geometry><sphere radius="0.1"/></geometry></collision>'


def stl(mesh: trimesh.Trimesh) -> bytes:
    return bytes(mesh.export(file_type="stl"))


def opened() -> bytes:
    mesh = CUBE.copy()
    mesh.update_faces(np.arange(12) > 0)
    return stl(mesh)


def inverted() -> bytes:
    mesh = CUBE.copy()
    mesh.invert()
    return stl(mesh)


def shown(content: bytes, file: str = "part.stl", **more: str) -> Callable[[Any], Iterable[Any]]:
    """Return a robot of three links, of which the second shows this file."""

    def elements(bench: Any) -> Iterable[Any]:
        other = bench.mesh("other.stl")
        yield bench.link("base", other)
        yield bench.link("arm", bench.mesh(file, **more))
        yield bench.link("hand", other)
        yield bench.joint("shoulder", "base", "arm", xyz="0 0 0.4")
        yield bench.joint("wrist", "arm", "hand", xyz="0 0 0.4")
        yield {"part.stl": content, "other.stl": stl(CUBE)}

    return elements


def arm(link: Callable[[Any], str]) -> Callable[[Any], Iterable[Any]]:
    """Return a base and two links, of which the second is given."""

    def elements(bench: Any) -> Iterable[Any]:
        box = bench.box()
        yield bench.link("base", box, moments=(0.007, 0.007, 0.007))
        yield link(bench)
        yield bench.link("hand", box, moments=(0.007, 0.007, 0.007))
        yield bench.joint("shoulder", "base", "arm", xyz="0 0 0.4")
        yield bench.joint("wrist", "arm", "hand", xyz="0 0 0.4")

    return elements


def jointed(*held: str, kind: str = "continuous", **more: str) -> Callable[[Any], Iterable[Any]]:
    """Return two links and the joint between them."""

    def elements(bench: Any) -> Iterable[Any]:
        yield bench.link("base")
        yield bench.link("arm")
        yield bench.joint("shoulder", "base", "arm", kind, *held, **more)

    return elements


REDUCED = """<transmission name="t"><joint name="shoulder"/><actuator name="m">
<mechanicalReduction>50</mechanicalReduction></actuator></transmission>"""
"""Of the joint of `jointed`."""


def legs(**odd: Any) -> Callable[[Any], Iterable[Any]]:
    """Return two legs of three joints that mirror each other but for one thing."""

    def elements(bench: Any) -> Iterable[Any]:
        yield bench.link("trunk", mass=5.0)
        for side, sign in (("left", 1), ("right", -1)):
            parent = "trunk"
            for part, offset in (("hip", 0.1), ("thigh", 0.02), ("knee", 0.03)):
                name = f"{side}_{part}"
                mass = odd.get("mass", 1.0) if name == "left_knee" else 1.0
                axis = odd.get("axis", 1) if name == "left_knee" else 1
                y = odd.get("y", sign * offset) if name == "right_hip" else sign * offset
                yield bench.link(name, mass=mass, moments=(mass * 0.01,) * 3)
                yield bench.joint(
                    f"{name}_joint", parent, name, axis=f"0 {axis} 0", xyz=f"0 {y} -0.2"
                )
                parent = name

    return elements


TABLE: dict[str, Callable[[Any], Iterable[Any]]] = {
    "duplicate-name": lambda b: [b.link("a"), b.link("a")],
    "dangling-joint": lambda b: [b.link("a"), b.joint("j", "a", "b")],
    "cyclic-tree": lambda b: [b.link("a"), b.link("b"), b.joint("j", "b", "b")],
    "lost-base": lambda b: [b.link("a"), b.link("b")],
    "base-assumed": lambda b: [b.link("a")],
    "joint-kind": jointed(kind="hinge"),
    "joint-axis": jointed(axis="0 0 0"),
    "mimic": jointed('<mimic joint="nobody"/>'),
    "ill-typed": lambda b: [b.link("a", com="here")],
    "unknown-element": lambda b: [b.link("a"), "<jiont/>"],
    "mass-missing": lambda b: [*jointed()(b), b.link("c", mass=None), b.joint("k", "arm", "c")],
    "inertia-missing": arm(lambda b: b.link("arm", moments=(0.0, 0.0, 0.0))),
    "inertia-broken": arm(lambda b: b.link("arm", moments=(0.1, 0.1, 0.3))),
    "inertia-swapped": arm(
        lambda b: b.link("arm", b.box("0.05 0.05 0.5"), moments=(0.0004, 0.021, 0.021))
    ),
    "inertia-oversized": arm(lambda b: b.link("arm", b.box(), moments=(7.0, 7.0, 7.0))),
    "inertia-undersized": arm(lambda b: b.link("arm", b.box(), moments=(7e-9, 7e-9, 7e-9))),
    "mass-volume": arm(lambda b: b.link("arm", b.box(), mass=1000.0, moments=(7.0, 7.0, 7.0))),
    "mass-asymmetric": legs(mass=3.0),
    "limit-absurd": jointed(LIMIT.format(-90, 90, 1), kind="revolute"),
    "limit-range": jointed(LIMIT.format(1, -1, 1), kind="revolute"),
    "limit-zero": jointed(LIMIT.format(-1, 1, 0), kind="revolute"),
    "reduction": lambda b: [*jointed()(b), REDUCED],
    "mesh-missing": shown(stl(CUBE), "gone.stl"),
    "mesh-case": shown(stl(CUBE), "Part.STL"),
    "mesh-path": shown(stl(CUBE), "meshes/part.stl"),
    "mesh-outside": shown(stl(CUBE), "../../secret.stl"),
    "mesh-lfs-stub": shown(b"version https://git-lfs.github.com/spec/v1\noid sha256:a\nsize 4\n"),
    "mesh-unreadable": shown(b"\x01" * 200),
    "mesh-empty": shown(bytes(84)),
    "mesh-too-large": shown(bytes(64 * 2**20 + 1)),
    "mesh-inside-out": shown(inverted()),
    "mesh-open": shown(opened()),
    "mesh-units": shown(stl(CUBE.copy().apply_scale(1000))),
    "length-units": arm(lambda b: b.link("arm", com="0 0 400", moments=(0.007,) * 3)),
    "mesh-moved": shown(stl(CUBE), xyz="0 0 2"),
    "shape-size": arm(lambda b: b.link("arm", b.box("0.1 0 0.1"))),
    "axis-flipped": legs(axis=-1),
    "limb-mirrored": legs(y=0.1),
    "self-collision": lambda b: [
        *(b.link(name, COLLISION if name in "cd" else "") for name in "abcd"),
        *(b.joint(f"j{name}", "a", name) for name in "b"),
        *(b.joint(f"j{name}", "b", name) for name in "c"),
        b.joint("jd", "a", "d"),
    ],
    "mesh-concave": lambda b: [
        b.link("a", b.mesh("part.stl", role="collision")),
        {"part.stl": RING},
    ],
    "unsupported": lambda b: [
        *(b.link(f"l{at}") for at in range(300)),
        *(b.joint(f"j{at}", f"l{at}", f"l{at + 1}") for at in range(299)),
    ],
    # Pinocchio reads no revolute joint without a <limit>.
    "agreement": jointed(kind="revolute"),
    "file-refused": lambda b: ["<joint/>"],
}
"""A least description for each code, in URDF."""

MJCF: dict[str, str] = {
    "engine-refused": '<body><joint type="spiral"/><geom size="1"/></body>',
    # Two hinges about one line: nothing tells their accelerations apart.
    "engine-warning": '<body><joint/><joint/><geom size="1"/></body>',
    "keyframe-range": '<body><joint range="-1 1"/><geom size="1"/></body></worldbody>'
    '<keyframe><key qpos="0.1"/></keyframe><worldbody>',
}
"""What MJCF alone can show: the content of the world, and what follows it."""

ELSEWHERE: dict[str, str] = {}
"""Codes that no least description raises, with the reason; it should stay empty."""


@pytest.mark.parametrize("code", CODES)
def test_every_code_is_raised_by_a_least_description(bench: Any, code: str) -> None:
    if code in ELSEWHERE:
        pytest.skip(ELSEWHERE[code])
    base = None if code == "base-assumed" else "fixed"
    if code in MJCF:
        path = bench.folder / "robot.xml"
        path.parent.mkdir(parents=True)
        path.write_text(f"<mujoco><worldbody>{MJCF[code]}</worldbody></mujoco>")
        findings = inspect_robot(path, base=base).findings
    else:
        *elements, last = TABLE[code](bench)
        files = last if isinstance(last, dict) else {}
        elements = elements if isinstance(last, dict) else [*elements, last]
        path = bench.write(*elements, files=files)
        findings = inspect_robot(path, base=base, second_opinion=code == "agreement").findings
    told = [finding for finding in findings if finding.code == code]
    assert told, {finding.code for finding in findings}
    for finding in told:
        assert finding.what.strip()
        assert finding.fix.strip()
        assert finding.where.name
        assert Path(finding.where.file).name.startswith("robot.")
        # What was changed is said, and what was not changed is not said to be.
        assert (finding.severity == "repaired") <= (finding.done != "nothing")
        assert (finding.severity == "refused") <= (finding.done == "nothing")


def test_no_code_is_in_the_tables_that_no_finding_has() -> None:
    assert CODES.keys() >= {*TABLE, *MJCF, *ELSEWHERE}
    assert set(ELSEWHERE).isdisjoint({*TABLE, *MJCF})


def test_every_code_is_a_few_small_words_and_says_what_it_means() -> None:
    for code, meaning in CODES.items():
        assert code == code.lower().replace(" ", "-").replace("_", "-")
        assert meaning.endswith(".")


def test_a_place_reads_as_a_part_a_file_and_a_line() -> None:
    assert str(Where(kind="link", name="arm", file="r.urdf", line=3)) == "link arm (r.urdf:3)"
    assert str(Where(kind="file", name="r.urdf", file="r.urdf")) == "file r.urdf (r.urdf)"
    assert str(Where(kind="robot", name="r")) == "robot r"


def test_a_finding_without_a_known_code_cannot_be_made() -> None:
    with pytest.raises(ValueError, match="no code"):
        DescriptionFinding(
            code="oops", severity="info", where=Where(kind="a", name="b"), what="c", fix="d"
        )
