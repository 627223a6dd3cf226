"""Small valid files of each kind that morph reads, and XML spoiled by its structure."""

from __future__ import annotations

import io
import random
import struct
import xml.etree.ElementTree as ElementTree
import zipfile

URDF = b"""<robot name="two_links">
  <material name="grey"><color rgba="0.5 0.5 0.5 1"/></material>
  <link name="base">
    <inertial><origin xyz="0 0 0.1" rpy="0 0 0"/><mass value="1"/>
      <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial>
    <visual><geometry><box size="0.1 0.2 0.3"/></geometry><material name="grey"/></visual>
    <collision><geometry><mesh filename="package://own/part.stl" scale="0.1 0.1 0.1"/></geometry>
    </collision>
  </link>
  <link name="left_arm">
    <inertial><origin xyz="0.1 0 0"/><mass value="0.5"/>
      <inertia ixx="0.001" ixy="0" ixz="0" iyy="0.002" iyz="0" izz="0.002"/></inertial>
    <collision><origin xyz="0.1 0 0"/><geometry><cylinder radius="0.02" length="0.2"/></geometry>
    </collision>
  </link>
  <link name="right_arm"><inertial><mass value="0.5"/>
      <inertia ixx="0.001" ixy="0" ixz="0" iyy="0.002" iyz="0" izz="0.002"/></inertial></link>
  <joint name="left" type="revolute"><parent link="base"/><child link="left_arm"/>
    <origin xyz="0 0.1 0" rpy="0 0 1.57"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="5" velocity="2"/><dynamics damping="0.1" friction="0.2"/>
  </joint>
  <joint name="right" type="prismatic"><parent link="base"/><child link="right_arm"/>
    <axis xyz="1 0 0"/><limit lower="0" upper="0.2" effort="5" velocity="2"/>
    <mimic joint="left" multiplier="0.5" offset="0.01"/></joint>
</robot>"""

MJCF = b"""<mujoco model="arm">
  <compiler angle="degree" meshdir="."/>
  <default><default class="small"><geom size="0.03" rgba="1 0 0 1"/></default></default>
  <asset><mesh name="part" file="part.stl" scale="0.1 0.1 0.1"/><material name="grey"/></asset>
  <worldbody>
    <geom type="plane" size="1 1 0.1"/>
    <body name="upper" pos="0 0 1"><joint name="shoulder" type="hinge" axis="0 1 0" range="-90 90"/>
      <geom name="rod" type="capsule" fromto="0 0 0 0 0 -0.3" size="0.02" mass="1"/>
      <body name="lower" pos="0 0 -0.3"><joint name="elbow" damping="0.1" armature="0.01"/>
        <inertial pos="0 0 -0.1" mass="0.5" diaginertia="0.01 0.01 0.001"/>
        <geom class="small" type="sphere"/><geom type="mesh" mesh="part"/>
        <site name="tip" pos="0 0 -0.2"/></body></body>
    <body name="loose"><freejoint name="root"/><geom type="box" size="0.1 0.1 0.1"/></body>
  </worldbody>
  <equality><connect body1="lower" body2="upper" anchor="0 0 0"/></equality>
  <actuator><motor name="m" joint="shoulder" gear="2" ctrlrange="-1 1" ctrllimited="true"/>
    <position name="p" joint="elbow" kp="5"/></actuator>
  <sensor><jointpos joint="shoulder"/><accelerometer site="tip"/></sensor>
</mujoco>"""

XACRO = b"""<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="macros">
  <xacro:arg name="side" default="left"/><xacro:property name="mass" value="0.5"/>
  <xacro:property name="sizes" value="${dict(a=[0.1, 0.2], b=pi/2)}"/>
  <xacro:include filename="own.xacro" optional="true"/>
  <xacro:macro name="leg" params="name length:=${2*mass} *origin **more">
    <link name="$(arg side)_${name}"><inertial><mass value="${mass*length}"/>
      <inertia ixx="${sin(sizes.b)}" ixy="0" ixz="0" iyy="1" iyz="0" izz="${sizes['a'][1]+1}"/>
      <xacro:insert_block name="origin"/></inertial><xacro:insert_block name="more"/></link>
  </xacro:macro>
  <xacro:leg name="one"><origin xyz="0 ${-mass} 0"/><m><visual/></m></xacro:leg>
  <xacro:if value="${mass &lt; 1 and not False}"><xacro:call macro="leg" name="two" length="3">
    <origin/><m/></xacro:call></xacro:if>
  <xacro:unless value="$(eval 1 == 1)"><xacro:element xacro:name="link"/></xacro:unless>
  <joint name="j" type="continuous"><parent link="left_one"/><child link="left_two"/></joint>
</robot>"""

CORNERS = ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1))
FACES = ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))

OBJ = b"".join(
    [b"o part\n", *(b"v %d %d %d\n" % each for each in CORNERS)]
    + [b"f %d %d/1 %d//2\n" % (a + 1, b + 1, c + 1) for a, b, c in FACES]
)

PLY = b"".join(
    (
        b"ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n",
        b"property float z\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n",
        *(b"%d %d %d\n" % each for each in CORNERS),
        *(b"3 %d %d %d\n" % each for each in FACES),
    )
)

MODEL = b"""<model unit="millimeter" xml:lang="en"
 xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02">
 <resources><object id="1" type="model"><mesh><vertices>%s</vertices><triangles>%s</triangles>
 </mesh></object></resources><build><item objectid="1" transform="1 0 0 0 1 0 0 0 1 5 0 0"/></build>
</model>""" % (
    b"".join(b'<vertex x="%d" y="%d" z="%d"/>' % each for each in CORNERS),
    b"".join(b'<triangle v1="%d" v2="%d" v3="%d"/>' % each for each in FACES),
)

RELATIONS = b"""<Relationships
 xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship
 Target="/3D/3dmodel.model" Id="rel0"
 Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>"""

COLLADA = b"""<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="meter" meter="1"/><up_axis>Z_UP</up_axis></asset><library_geometries>
<geometry id="g"><mesh><source id="p"><float_array id="f" count="12">%s</float_array>
<technique_common><accessor source="#f" count="4" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices><triangles count="4">
<input semantic="VERTEX" source="#v" offset="0"/><p>%s</p></triangles></mesh></geometry>
</library_geometries><library_visual_scenes><visual_scene id="s"><node><translate>0 0 1</translate>
<rotate>0 0 1 90</rotate><instance_geometry url="#g"/></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>""" % (
    b" ".join(b"%d" % number for each in CORNERS for number in each),
    b" ".join(b"%d" % number for each in FACES for number in each),
)

CARD = b"""schema = "morph.card/1"
name = "own"
title = "Card"
description = "robot.urdf"
base = "fixed"
source = [{ what = "all", from = "Chosen" }]
licence = "Apache-2.0"
tasks = ["balance"]
checks = { mass_kg = 2.0, dof = 2 }

[[motor]]
actuator = "left"
model = "ideal"
limit = 10.0
"""

ASSEMBLY = b"""schema = "morph.assembly/1"
name = "own"
unit = "mm"
density_kg_m3 = 1200.0

[[link]]
name = "base"
mesh = "part.stl"

[[link]]
name = "arm"
mesh = "part.stl"
mass_kg = 0.1

[[joint]]
name = "hinge"
kind = "revolute"
parent = "base"
child = "arm"
origin = [0.0, 0.0, 10.0]
axis = [0.0, 1.0, 0.0]
limits_deg = [-90.0, 90.0]
"""

CSV = b"time,hip.position,hip.velocity\n" + b"".join(
    b"%.2f,%.3f,%.3f\n" % (0.01 * step, 0.1 * step, 1.0) for step in range(12)
)


def stl() -> bytes:
    """Return a tetrahedron as binary STL."""
    faces = b"".join(
        struct.pack("<12fH", 0, 0, 0, *(x for corner in face for x in CORNERS[corner]), 0)
        for face in FACES
    )
    return bytes(80) + struct.pack("<I", len(FACES)) + faces


def threemf() -> bytes:
    """Return the same as 3MF."""
    sink = io.BytesIO()
    with zipfile.ZipFile(sink, "w", zipfile.ZIP_DEFLATED) as file:
        file.writestr("_rels/.rels", RELATIONS)
        file.writestr("3D/3dmodel.model", MODEL)
    return sink.getvalue()


def recorded(ending: str) -> bytes:
    """Return a short motion as `.npz`, `.parquet` or `.h5`."""
    import numpy as np

    columns = {"time": 0.01 * np.arange(12), "hip.position": np.linspace(0.0, 1.0, 12)}
    sink = io.BytesIO()
    if ending == ".npz":
        np.savez(sink, **columns)  # type: ignore[arg-type]
    elif ending == ".parquet":
        import pyarrow
        from pyarrow import parquet

        parquet.write_table(pyarrow.table(columns), sink)
    else:
        import h5py

        with h5py.File(sink, "w") as file:
            for name, values in columns.items():
                file.create_dataset(name, data=values, chunks=(5,), compression="gzip")
    return sink.getvalue()


HOSTILE = (
    *("nan", "inf", "-inf", "1e308", "1e-320", "-1", "0", "-0", "", " ", "1 2 3", "1 2", "1e5"),
    *("0 0 0", "1 nan 0", "9" * 400, "0x10", "1_0", "\u0669", "\u202e", "é" * 50, "a/b", "..", "."),
    *("../../secret", "/etc/passwd", "file:///dev/zero", "package://own/part.stl", "part.stl", "~"),
    *("base", "left_arm", "left", "world", "hinge", "fixed", "floating", "planar", "mesh", "true"),
    *("${1/0}", "${mass}", "${'x'*9**9}", "$(find own)", "$(arg side)"),
    *("${a", "$(eval 1", "${[[]]*9}"),
    *("sphere", "capsule", "ball", "free", "5 5 5 5 5 5 5", "-1 1", "1 -1", "%s%n", "{0}", "None"),
)
"""Values that somebody, some day, gives an attribute."""


def spoil(content: bytes, rng: random.Random) -> bytes:
    """Return a document with one to three parts changed, moved, copied, renamed or taken away.

    Raises:
        ElementTree.ParseError: It is no XML.
    """
    root = ElementTree.fromstring(content)
    for _ in range(rng.randint(1, 3)):
        everything = list(root.iter())
        one, other = rng.choice(everything), rng.choice(everything)
        match rng.randrange(7):
            case 0 | 1 if one.attrib:
                one.set(rng.choice(list(one.attrib)), rng.choice(HOSTILE))
            case 2 if one.attrib:
                del one.attrib[rng.choice(list(one.attrib))]
            case 3 if other.attrib:
                one.set(*rng.choice(list(other.attrib.items())))
            case 4 if len(one):
                one.remove(rng.choice(list(one)))
            case 5 if other is not root:
                # A copy, since a tree that holds itself has no end.
                one.append(ElementTree.fromstring(ElementTree.tostring(other)))
            case 6:
                one.tag, one.text = other.tag, rng.choice((one.text, *HOSTILE))
    return ElementTree.tostring(root)
