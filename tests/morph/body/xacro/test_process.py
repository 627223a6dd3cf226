"""Xacro that people wrote for their robots."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

from morph.body.xacro import expand, read

NAMESPACE = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'
SECRET = "the-secret-outside"


def robot(inside: str) -> str:
    return f'<robot {NAMESPACE} name="r">\n{inside}\n</robot>'


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A description's folder, with something outside that it must not reach."""
    (tmp_path / "outside").mkdir()
    secret = f'<robot {NAMESPACE}><link name="{SECRET}"/></robot>'
    for name in ("secret.xacro", "secret.yaml"):
        (tmp_path / "outside" / name).write_text(secret if name.endswith("o") else f"a: {SECRET}")
    own = tmp_path / "own"
    (own / "urdf").mkdir(parents=True)
    (own / "package.xml").write_text("<package><name>mine</name></package>")
    (own / "urdf" / "part.xacro").write_text(robot('<link name="part"/>'))
    (own / "numbers.yaml").write_text("mass: 2.5\nlimits: {hip: [1, 2]}\nangle: !degrees 180\n")
    return own


def names(content: bytes) -> list[str]:
    return [element.get("name", "") for element in ElementTree.fromstring(content)]


def expanded(folder: Path, inside: str, **arguments: str) -> bytes:
    path = folder / "urdf" / "robot.urdf.xacro"
    path.write_text(robot(inside))
    return expand(path, folder, arguments)


def tree(element: ElementTree.Element) -> list[object]:
    """Return an element as nested lists, its numbers as numbers."""

    def values(text: str) -> list[object]:
        parts: list[object] = []
        for word in text.split():
            try:
                parts.append(float(word))
            except ValueError:
                parts.append(word)
        return parts

    attributes = sorted(
        (name, values(text)) for name, text in element.attrib.items() if "xmlns" not in name
    )
    return [element.tag, attributes, values(element.text or ""), [tree(each) for each in element]]


@pytest.mark.parametrize(
    ("xacro", "urdf", "folder"),
    [
        (
            "aqua/aqua_description/urdf/aqua.urdf.xacro",
            "aqua/aqua_description/urdf/aqua.urdf",
            "aqua",
        ),
        ("solo/resources/xacro/solo8.urdf.xacro", "solo/resources/solo8.urdf", "solo"),
        ("solo/resources/xacro/solo12.urdf.xacro", "solo/resources/solo12.urdf", "solo"),
    ],
)
def test_a_public_robot_expands_to_its_published_urdf(
    real_robots: Path, xacro: str, urdf: str, folder: str
) -> None:
    content = expand(real_robots / xacro, real_robots / folder)
    # The same expressions by the same rules of IEEE 754: not a bit may differ.
    assert tree(ElementTree.fromstring(content)) == tree(
        ElementTree.parse(real_robots / urdf).getroot()
    )


def test_what_xacro_knows_is_worked_out(folder: Path) -> None:
    content = expanded(
        folder,
        """<xacro:arg name="side" default="left"/>
        <xacro:property name="length" value="0.5"/>
        <xacro:property name="box" value="${dict(x=1, y=[2, 3])}"/>
        <xacro:property name="data" value="${xacro.load_yaml('$(find mine)/numbers.yaml')}"/>
        <xacro:macro name="leg" params="name mass:=${length*2} *origin **more">
          <link name="$(arg side)_${name}" mass="${mass}"><xacro:insert_block name="origin"/></link>
          <xacro:insert_block name="more"/>
        </xacro:macro>
        <xacro:leg name="a"><origin x="${-length}"/><m><inner name="i"/></m></xacro:leg>
        <xacro:include filename="$(find mine)/urdf/part.xacro"/>
        <xacro:include filename="p*.xacro"/>
        <xacro:include filename="not_there.xacro" optional="true"/>
        <xacro:include filename="part.xacro" ns="other"/>
        <v a="${sin(pi/2)}" b="${math.cos(0)}" c="${box.y[1]}" d="${data.limits.hip[0]}"
           e="${data['mass']}" f="${data.angle}" g="${'big' if length > 1 else 'small'}"
           h="$(eval 2*3)" i="$$(x)" j="${[1,2]+[3]}" k="${round(2.5)}" l="$(optenv HOME none)"
           n="${radians(180)}" o="${max(1, 2) % 2 == 0 and not False}"/>
        <xacro:if value="${length &lt; 1}"><link name="yes"/></xacro:if>
        <xacro:unless value="${length &lt; 1}"><link name="no"/></xacro:unless>""",
        side="right",
    )
    root = ElementTree.fromstring(content)
    assert [(each.tag, each.get("name")) for each in root if each.tag != "v"] == [
        ("link", "right_a"),
        ("inner", "i"),
        *[("link", "part")] * 3,
        ("link", "yes"),
    ]
    values = root.find("v")
    assert values is not None
    assert list(values.attrib.values()) == [
        *("1.0", "1.0", "3", "1", "2.5", str(3.141592653589793), "small"),
        *("6", "$(x)", "[1, 2, 3]", "2", "none", str(3.141592653589793), "True"),
    ]
    origin = root.find("link/origin")
    assert origin is not None
    assert origin.get("x") == "-0.5"


def test_a_macro_that_calls_itself_may_count_down(folder: Path) -> None:
    content = expanded(
        folder,
        """<xacro:macro name="chain" params="n">
        <link name="link${n}"/>
        <xacro:if value="${n > 0}"><xacro:chain n="${n-1}"/></xacro:if>
        </xacro:macro><xacro:chain n="100"/>""",
    )
    assert names(content) == [f"link{n}" for n in range(100, -1, -1)]


def test_each_element_knows_the_line_of_the_macro_it_came_from(folder: Path) -> None:
    path = folder / "urdf" / "robot.xacro"
    path.write_text(robot('<xacro:include filename="part.xacro"/>\n\n<link name="b"/>'))
    places = [(each.get("name"), each.file, each.line) for each in read(path, folder).children()]
    assert places == [("part", str(folder / "urdf" / "part.xacro"), 2), ("b", str(path), 4)]
