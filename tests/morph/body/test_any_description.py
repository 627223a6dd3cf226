"""Whatever a description says: a robot or a refusal, the same each time, and no mass lost."""

from __future__ import annotations

import math
import tempfile
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from morph.body.load import load
from morph.body.robot import Robot
from morph.errors import DescriptionRefused, MorphError

STRANGE_NAMES = ("", "world", "base", "a b", "é", "../x", "a" * 300, "left_0", "right_0")
STRANGE_NUMBERS = (
    *("0", "-1", "1e-9", "1e9", "1e308", "1e-320", "nan", "inf", "-inf", "", "x", "1,5", "0x1"),
    *("\u0661", "1 2", "9" * 400),
)
STRANGE_VECTORS = (
    *("1 1", "1 2 3 4", "nan 0 0", "0 inf 0", "", "a b c", "1e308 1e308 1e308", "0 0 1e-320"),
    *("-1 -1 -1", "0 0 0"),
)
FILES = ("part.stl", "package://a/part.stl", "../../secret.stl", "/dev/zero", "", ".", "a\\b.dae")


@st.composite
def mostly(draw: st.DrawFn, usual: tuple[str, ...], strange: tuple[str, ...]) -> str:
    """Draw a usual value and now and then a strange one, so that some descriptions are robots."""
    return draw(st.sampled_from(strange if draw(st.integers(0, 49)) == 7 else usual))


def called(kind: str) -> st.SearchStrategy[str]:
    return mostly(tuple(f"{kind}{number}" for number in range(4)), STRANGE_NAMES)


number = mostly(("0.1", "0.2", "0.3", "1", "1.5"), STRANGE_NUMBERS)
vector = mostly(("0 0 0.1", "1 0 0", "0 1 0", "0.1 0.2 0.3"), STRANGE_VECTORS)
file = st.sampled_from(FILES)
any_text = st.one_of(
    *(st.sampled_from(each) for each in (STRANGE_NAMES, STRANGE_NUMBERS, STRANGE_VECTORS, FILES)),
    st.text(max_size=20),
)


def node(tag: str, attributes: dict[str, str], *children: str) -> str:
    """Return an element as text; what XML cannot hold is left out of its attributes."""
    element = ElementTree.Element(tag)
    for key, value in attributes.items():
        element.set(key, "".join(mark for mark in value if mark.isprintable()))
    whole = ElementTree.tostring(element, encoding="unicode")
    return whole[: -len(" />")] + ">" + "".join(children) + f"</{tag}>"


@st.composite
def some(draw: st.DrawFn, tag: str, **attributes: st.SearchStrategy[str]) -> str:
    """Draw an element that may lack any of its attributes, or be missing itself."""
    if draw(st.integers(0, 19)) == 7:
        return ""
    held = {key: draw(value) for key, value in attributes.items() if draw(st.integers(0, 39)) != 7}
    return node(tag, held)


@st.composite
def shape(draw: st.DrawFn) -> str:
    inner = st.one_of(
        some("box", size=vector),
        some("sphere", radius=number),
        some("cylinder", radius=number, length=number),
        some("mesh", filename=file, scale=vector),
    )
    kind = draw(st.sampled_from(("visual", "collision")))
    return node(
        kind, {}, draw(some("origin", xyz=vector, rpy=vector)), node("geometry", {}, draw(inner))
    )


@st.composite
def link(draw: st.DrawFn, index: int) -> str:
    products = dict.fromkeys(("ixy", "ixz", "iyz"), mostly(("0", "0.01"), STRANGE_NUMBERS))
    moments = dict.fromkeys(("ixx", "iyy", "izz"), mostly(("1", "1.5"), STRANGE_NUMBERS))
    inertial = node(
        "inertial",
        {},
        draw(some("origin", xyz=vector, rpy=vector)),
        draw(some("mass", value=number)),
        draw(some("inertia", **moments, **products)),
    )
    shapes = draw(st.lists(shape(), max_size=2))
    name = draw(mostly((f"link{index}",), STRANGE_NAMES))
    return node("link", {"name": name}, inertial if draw(st.integers(0, 9)) else "", *shapes)


@st.composite
def joint(draw: st.DrawFn, index: int) -> str:
    kinds = mostly(
        ("revolute", "continuous", "prismatic", "fixed"), ("floating", "planar", "ball", "")
    )
    above = mostly(tuple(f"link{each}" for each in range(index + 1)), STRANGE_NAMES)
    below = mostly((f"link{index + 1}",), (*STRANGE_NAMES, "link0", "link1"))
    upper = mostly(("0.5", "1.5"), STRANGE_NUMBERS)
    follow = some("mimic", joint=called("joint"), multiplier=number, offset=number)
    return node(
        "joint",
        {
            "name": draw(mostly((f"joint{index}",), STRANGE_NAMES)),
            "type": draw(kinds),
        },
        draw(some("parent", link=above)),
        draw(some("child", link=below)),
        draw(some("origin", xyz=vector, rpy=vector)),
        draw(some("axis", xyz=vector)),
        draw(
            some(
                "limit",
                lower=mostly(("-1", "0"), ("nan", "2")),
                upper=upper,
                effort=number,
                velocity=number,
            )
        ),
        draw(some("dynamics", damping=number, friction=number)),
        draw(follow) if draw(st.integers(0, 4)) == 4 else "",
    )


@st.composite
def urdf(draw: st.DrawFn) -> str:
    count = draw(st.integers(0, 4))
    links = [draw(link(index)) for index in range(count)]
    joints = [draw(joint(index)) for index in range(count - (draw(st.integers(0, 19)) != 7))]
    parts = draw(st.permutations([*links, *joints]))
    return node("robot", {"name": draw(called("robot"))}, *parts)


@st.composite
def body(draw: st.DrawFn, path: str = "b") -> str:
    geom = some(
        "geom",
        name=mostly((f"geom_{path}",), STRANGE_NAMES),
        type=mostly(("sphere", "box", "capsule"), ("mesh", "plane", "hfield", "?", "ellipsoid")),
        size=mostly(("0.1 0.2 0.3",), STRANGE_VECTORS),
        mass=number,
        pos=vector,
    )
    hinge = some(
        "joint",
        name=mostly((f"joint_{path}",), STRANGE_NAMES),
        type=mostly(("hinge", "slide", "ball"), ("free", "?")),
        axis=vector,
        range=mostly(("-1 1", "0 0.5"), STRANGE_VECTORS),
        damping=number,
        armature=number,
    )
    inner = [
        draw(body(f"{path}{each}")) for each in range(draw(st.integers(0, 2 - len(path) // 2)))
    ]
    inertial = some(
        "inertial", pos=vector, mass=number, diaginertia=mostly(("1 1 1.5",), STRANGE_VECTORS)
    )
    return node(
        "body",
        {"name": draw(mostly((f"body_{path}",), STRANGE_NAMES)), "pos": draw(vector)},
        draw(inertial) if draw(st.integers(0, 2)) else "",
        draw(some("freejoint")) if path == "b" and draw(st.booleans()) else draw(hinge),
        *draw(st.lists(geom, max_size=1)),
        *inner,
    )


@st.composite
def mjcf(draw: st.DrawFn) -> str:
    angle = mostly(("degree", "radian"), STRANGE_NAMES)
    joints = mostly(("joint_b0", "joint_b1", "joint_b"), STRANGE_NAMES)
    bodies = mostly(("body_b0", "body_b1", "body_b"), STRANGE_NAMES)
    mesh = some("mesh", name=called("mesh"), file=file, scale=vector)
    # All but the bodies is rare: most of it names parts that may not be there.
    rare = st.integers(0, 3).map(lambda chance: chance == 3)
    return node(
        "mujoco",
        {"model": draw(called("robot"))},
        draw(some("compiler", angle=angle)) if draw(rare) else "",
        draw(some("option", timestep=number, gravity=vector)) if draw(rare) else "",
        node("asset", {}, draw(mesh) if draw(rare) else ""),
        node("worldbody", {}, draw(body())),
        node("actuator", {}, draw(some("motor", joint=joints, gear=number)) if draw(rare) else ""),
        node("sensor", {}, draw(some("jointpos", joint=joints)) if draw(rare) else ""),
        node(
            "equality",
            {},
            draw(some("connect", body1=bodies, body2=bodies, anchor=vector)) if draw(rare) else "",
        ),
    )


@st.composite
def anything(draw: st.DrawFn, tags: tuple[str, ...], depth: int = 0) -> str:
    """Draw a tree of known words in places where nobody puts them."""
    keys = ("name", "type", "xyz", "rpy", "value", "link", "joint", "filename", "file", "size")
    held = draw(
        st.dictionaries(st.sampled_from((*keys, "class", "mass", "pos")), any_text, max_size=4)
    )
    inner = [] if depth > 3 else draw(st.lists(anything(tags, depth + 1), max_size=3))
    return node(tags[0] if depth == 0 else draw(st.sampled_from(tags)), held, *inner)


BASE = '<link name="base"><inertial><mass value="1"/></inertial></link>'
URDF_TAGS = (
    *("robot", "link", "joint", "inertial", "mass", "inertia", "origin", "visual", "collision"),
    *("geometry", "mesh", "box", "material", "parent", "child", "limit", "mimic", "transmission"),
    *("gazebo", "mujoco", "compiler", "xacro:include", "drake:joint"),
)
MJCF_TAGS = (
    *(
        "mujoco",
        "worldbody",
        "body",
        "geom",
        "joint",
        "freejoint",
        "inertial",
        "include",
        "default",
    ),
    *("asset", "mesh", "texture", "hfield", "compiler", "option", "actuator", "motor", "general"),
    *("sensor", "tendon", "spatial", "keyframe", "key", "equality", "weld", "contact", "exclude"),
    *("frame", "replicate", "composite", "flexcomp", "attach", "model", "plugin", "extension"),
)
FORMS = {
    "urdf": (".urdf", urdf()),
    "mjcf": (".xml", mjcf()),
    # With a link, so that it is not refused at once.
    "any urdf": (".urdf", anything(URDF_TAGS).map(lambda text: f"{text[:-8]}{BASE}</robot>")),
    "any mjcf": (".xml", anything(MJCF_TAGS)),
}


def outcome(path: Path) -> tuple[Robot | None, str]:
    """Return the robot, if there is one, and all that was said; no other error is caught."""
    try:
        robot = load(path)
    except DescriptionRefused as error:
        return None, f"{error} {error.findings}"
    except MorphError as error:
        return None, str(error)
    return robot, f"{robot.links} {robot.joints} {robot.actuators} {robot.findings}"


def loaded(content: str, ending: str) -> Robot | None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"robot{ending}"
        path.write_text(content, encoding="utf-8")
        robot, said = outcome(path)
        assert outcome(path)[1] == said
    return robot


@pytest.mark.parametrize("form", FORMS)
@settings(max_examples=50, deadline=None, suppress_health_check=list(HealthCheck))
@given(data=st.data())
def test_any_description_is_a_robot_or_a_refusal_and_always_the_same(
    form: str, data: st.DataObject
) -> None:
    ending, contents = FORMS[form]
    loaded(data.draw(contents), ending)


@settings(max_examples=100, deadline=None, suppress_health_check=list(HealthCheck))
@given(content=urdf())
def test_a_urdf_that_loads_without_a_word_keeps_all_its_mass(content: str) -> None:
    robot = loaded(content, ".urdf")
    if robot is None or any(each.severity == "repaired" for each in robot.findings):
        return
    masses = [
        float(each.get("value", "0"))
        for part in ElementTree.fromstring(content).iter("link")
        for each in part.iter("mass")
    ]
    # A sum of at most four doubles: relative rounding of 4 * 2^-53.
    assert math.isclose(robot.mass, sum(masses), rel_tol=1e-12)
