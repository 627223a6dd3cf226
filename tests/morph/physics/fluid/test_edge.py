"""The trailing edge is where the shapes of a link, or its user, have it."""

from __future__ import annotations

import mujoco
import pytest

from morph.body.load import load
from morph.body.spec import spec_of
from morph.errors import EffectError
from morph.physics.fluid.edge import trailing_edge
from morph.physics.fluid.thrust import Thrust

TURNED = """
<mujoco>
  <worldbody>
    <body name="fin">
      <joint/>
      <geom type="box" pos="{pos}" size="{size}" mass="1"/>
      <geom type="sphere" size="0.5" mass="1" contype="0" conaffinity="0"/>
    </body>
  </worldbody>
</mujoco>
"""


def test_the_swimmers_paddles_shed_at_their_ends_and_its_hull_does_not() -> None:
    swimmer = load("hexapod_swimmer")
    model = spec_of(swimmer).compile()
    with pytest.raises(EffectError, match="no paddle"):
        trailing_edge(model, "hull")
    edge = trailing_edge(model, "left_rear_paddle")
    # card.toml: 0.16 by 0.05 by 0.003 m, its middle 0.088 m behind the hip.
    assert edge.middle == pytest.approx([-0.168, 0.0, 0.0], abs=1e-12)
    assert edge.span == pytest.approx(0.05, abs=1e-12)
    assert edge.chord.tolist() == [1.0, 0.0, 0.0]
    assert edge.normal.tolist() == [0.0, 0.0, 1.0]


@pytest.mark.parametrize(
    ("pos", "size", "middle", "chord", "normal", "span"),
    [
        ("0 0.1 0", "0.02 0.1 0.001", (0, 0.2, 0), (0, -1, 0), (0, 0, 1), 0.04),
        ("0 0 -0.1", "0.001 0.02 0.1", (0, 0, -0.2), (0, 0, 1), (1, 0, 0), 0.04),
        ("0.1 0 0", "0.1 0.001 0.3", (0.1, 0, -0.3), (0, 0, 1), (0, 1, 0), 0.2),
        ("0 0 0", "0.1 0.1 0.001", (-0.1, 0, 0), (1, 0, 0), (0, 0, 1), 0.2),
    ],
)
def test_the_edge_is_the_side_farthest_from_the_hinge_and_behind_if_two_are(
    pos: str,
    size: str,
    middle: tuple[float, ...],
    chord: tuple[float, ...],
    normal: tuple[float, ...],
    span: float,
) -> None:
    model = mujoco.MjModel.from_xml_string(TURNED.format(pos=pos, size=size))
    edge = trailing_edge(model, "fin")
    assert edge.middle == pytest.approx(middle, abs=1e-12)
    assert edge.chord.tolist() == list(chord)
    assert edge.normal.tolist() == list(normal)
    assert edge.span == pytest.approx(span, abs=1e-12)


def test_what_is_no_paddle_is_refused() -> None:
    thick = mujoco.MjModel.from_xml_string(TURNED.format(pos="0 0 0", size="0.1 0.1 0.05"))
    with pytest.raises(EffectError, match=r"0\.2 by 0\.2 by 0\.1 m: no paddle") as caught:
        trailing_edge(thick, "fin")
    assert caught.value.where == "link fin"
    bare = mujoco.MjModel.from_xml_string(
        "<mujoco><worldbody><body name='fin'><inertial mass='1' pos='0 0 0' diaginertia='1 1 1'/>"
        "<joint/></body></worldbody></mujoco>"
    )
    with pytest.raises(EffectError, match="no shape that water could touch"):
        trailing_edge(bare, "fin")


def test_an_edge_told_askew_has_its_chord_across_its_normal() -> None:
    edge = Thrust(body="fin", span=0.1, x=-0.3, z=-0.1, nx=0.0, nz=0.5).edge()
    assert edge.chord.tolist() == [1.0, 0.0, 0.0]
    assert edge.normal.tolist() == [0.0, 0.0, 1.0]


@pytest.mark.parametrize(
    "told", [{"x": 0.1}, {"nz": 1.0}, {"z": 0.1, "nz": 1.0}], ids=["no normal", "no place", "along"]
)
def test_an_edge_without_a_chord_is_refused(told: dict[str, float]) -> None:
    with pytest.raises(EffectError, match="has no chord"):
        Thrust(body="fin", span=0.1, **told).edge()
