"""The library of physics: every effect, listed once."""

from __future__ import annotations

from morph.errors import EffectError
from morph.nearest import nearest
from morph.physics.actuator.actuator_delay import ActuatorDelay
from morph.physics.actuator.actuator_lag import ActuatorLag
from morph.physics.actuator.back_emf import BackEmf
from morph.physics.actuator.dead_zone import DeadZone
from morph.physics.actuator.speed_torque_limit import SpeedTorqueLimit
from morph.physics.actuator.thermal_derating import ThermalDerating
from morph.physics.actuator.torque_saturation import TorqueSaturation
from morph.physics.actuator.torque_scale import TorqueScale
from morph.physics.actuator.voltage_sag import VoltageSag
from morph.physics.body.com_offset import ComOffset
from morph.physics.body.external_push import ExternalPush
from morph.physics.body.link_inertia import LinkInertia
from morph.physics.body.payload import Payload
from morph.physics.body.tether import Tether
from morph.physics.contact.contact_friction import ContactFriction
from morph.physics.contact.contact_softness import ContactSoftness
from morph.physics.contact.restitution import Restitution
from morph.physics.effect import Effect as Effect
from morph.physics.fluid.added_mass import AddedMass
from morph.physics.fluid.buoyancy import Buoyancy
from morph.physics.fluid.fluid_current import FluidCurrent
from morph.physics.fluid.linear_drag import LinearDrag
from morph.physics.fluid.quadratic_drag import QuadraticDrag
from morph.physics.fluid.thrust import Thrust
from morph.physics.joint.armature import Armature
from morph.physics.joint.backlash import Backlash
from morph.physics.joint.cogging import Cogging
from morph.physics.joint.coulomb_friction import CoulombFriction
from morph.physics.joint.end_stop import EndStop
from morph.physics.joint.hysteresis import Hysteresis
from morph.physics.joint.joint_stiffness import JointStiffness
from morph.physics.joint.load_dependent_friction import LoadDependentFriction
from morph.physics.joint.position_dependent_friction import PositionDependentFriction
from morph.physics.joint.quadratic_damping import QuadraticDamping
from morph.physics.joint.series_elasticity import SeriesElasticity
from morph.physics.joint.stribeck_friction import StribeckFriction
from morph.physics.joint.viscous_friction import ViscousFriction
from morph.physics.sensor.sensor_bias import SensorBias
from morph.physics.sensor.sensor_scale import SensorScale
from morph.physics.sensor.timestamp_offset import TimestampOffset
from morph.physics.world.base_tilt import BaseTilt
from morph.physics.world.ground import Ground
from morph.physics.world.ground_slope import GroundSlope

EFFECTS: tuple[type[Effect], ...] = (
    ViscousFriction,
    CoulombFriction,
    StribeckFriction,
    LoadDependentFriction,
    PositionDependentFriction,
    QuadraticDamping,
    JointStiffness,
    Cogging,
    Hysteresis,
    Backlash,
    SeriesElasticity,
    EndStop,
    Armature,
    ActuatorDelay,
    ActuatorLag,
    TorqueScale,
    TorqueSaturation,
    SpeedTorqueLimit,
    BackEmf,
    ThermalDerating,
    VoltageSag,
    DeadZone,
    SensorBias,
    SensorScale,
    TimestampOffset,
    LinkInertia,
    ComOffset,
    Payload,
    ExternalPush,
    Tether,
    BaseTilt,
    AddedMass,
    Buoyancy,
    LinearDrag,
    QuadraticDrag,
    Thrust,
    FluidCurrent,
    Ground,
    GroundSlope,
    ContactFriction,
    ContactSoftness,
    Restitution,
)
"""Every effect that a simulation can have; `Effect.suspects` says where a diagnosis looks."""


def effect_class(name: str, *, where: str = "morph.physics.EFFECTS") -> type[Effect]:
    """Return an effect's class by its name.

    Args:
        name: Its name.
        where: Who names it, for the error.

    Raises:
        EffectError: There is no such effect.
    """
    known = {effect.name: effect for effect in EFFECTS}
    if name in known:
        return known[name]
    raise EffectError(
        f"there is no effect {name!r}",
        where=where,
        fix=f"the nearest are {nearest(name, known)}; `morph list effects` says what each does",
    )
