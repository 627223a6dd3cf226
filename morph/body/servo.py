"""Position servos that a card may name as the motor of a joint."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Servo:
    """A position servo as its maker and its users describe it."""

    name: str
    """The maker's name for it."""
    kp: float
    """Torque per position error, N m/rad."""
    kv: float
    """Torque per velocity, N m s/rad."""
    limit: float
    """Greatest torque, N m."""
    armature: float
    """Inertia of its rotor seen at the horn, kg m2."""
    friction: float | None = None
    """Dry friction of its gears, N m; None if nobody measured it."""


DYNAMIXELS = (
    # Stall torque and no-load speed at 12 V, gear ratio: ROBOTIS e-manual, pages mx-28,
    # mx-64, ax-12a and ax-18a. The maker advises loads of a fifth of the stall torque.
    # kv: a DC motor's torque falls from stall to nothing at its no-load speed, so
    # kv = stall / speed: 2.5 / 5.76, 6.0 / 6.60, 1.5 / 6.18, 1.8 / 10.16.
    # kp of the MX: duty cycle per error is 0.158 per rad and unit of P (measured by
    # Rhoban/bam, class MXActuator); at the usual P of 32, kp = 32 * 0.158 * stall.
    # kp of the AX: full torque at the default compliance slope, 32 steps of 0.29
    # degrees, so kp = stall / 0.162 rad.
    # Armature: the MX-64's as identified (Rhoban/bam, params/mx64/m1.json). The maker
    # says of the MX-28 only that its motor is a coreless maxon: it is assumed to be the
    # RE-max 17, with a rotor of 0.868 g cm2, times 193^2. Of the AX no rotor is
    # published; the same one is assumed, times 254^2.
    Servo(name="MX-28", kp=12.6, kv=0.434, limit=2.5, armature=0.00323),
    Servo(name="MX-64", kp=30.3, kv=0.909, limit=6.0, armature=0.012),
    Servo(name="AX-12", kp=9.26, kv=0.243, limit=1.5, armature=0.0056),
    Servo(name="AX-18", kp=11.1, kv=0.177, limit=1.8, armature=0.0056),
)
"""Servos of ROBOTIS as position servos at 12 V."""

X_SERIES = (
    # Stall torque and no-load speed: ROBOTIS e-manual, pages xl320 (7.4 V), xl330-m288 (5 V),
    # xl430-w250, xm430-w350 and xm540-w270 (12 V) and mx-106 (12 V). kv = stall / speed, as above.
    # kp: the duty cycle is P / 128 per tick of 2 pi / 4096, and whole at 885 (pages as above,
    # "Position PID Gain"), at the gains set by the maker: 400, 640 and 800. Of the MX-106 as of the
    # MX; the XL-320 is assumed to take an MX's duty cycle per tick, of which it has 1024 in 300
    # degrees, at its P of 32.
    # Armature and friction of XL-320, XL330 and MX-106 as identified (Rhoban/bam, params/xl320/
    # m2.json, xl330/m1.json, mx106/m1.json; of the XL-320 the Stribeck part is its friction). Of
    # the others no rotor is published: that of the XL330 is assumed in the XL430 and of the MX-64
    # in the XM430 and XM540, times the square of the gear ratio by theirs (258.5, 353.5 and 272.5,
    # to 288.4 and 200).
    Servo(name="XL-320", kp=0.59, kv=0.0327, limit=0.39, armature=0.00111, friction=0.03),
    Servo(name="XL330-M288", kp=1.2, kv=0.0482, limit=0.52, armature=0.00199, friction=0.018),
    Servo(name="XL430-W250", kp=5.52, kv=0.235, limit=1.5, armature=0.0016),
    Servo(name="XM430-W350", kp=18.9, kv=0.851, limit=4.1, armature=0.0375),
    Servo(name="XM540-W270", kp=48.8, kv=3.37, limit=10.6, armature=0.0223),
    Servo(name="MX-106", kp=42.5, kv=1.78, limit=8.4, armature=0.0266, friction=0.104),
)
"""Further servos of ROBOTIS."""

HOBBY = (
    # Stall torque and speed as sold: SG90 1.8 kgf cm and 0.1 s for 60 degrees at 4.8 V, MG996R
    # 11 kgf cm and 0.14 s at 6 V (Tower Pro), SCS15 15 kgf cm and 0.18 s at 6 V, STS3250
    # 50 kgf cm and 0.133 s at 12 V (Feetech). kv = stall / speed. kp: nobody publishes it;
    # full torque at 0.1 rad is assumed of all. Nor a rotor: that of the XL-320 is assumed in the
    # SG90 (gears of about 180 for 238), that of the STS3215 in the others.
    Servo(name="SG90", kp=1.77, kv=0.0169, limit=0.177, armature=0.0006),
    Servo(name="MG996R", kp=10.8, kv=0.144, limit=1.08, armature=0.028),
    Servo(name="SCS15", kp=14.7, kv=0.253, limit=1.47, armature=0.028),
    Servo(name="STS3250", kp=49.0, kv=0.623, limit=4.9, armature=0.028),
)
"""Servos whose makers tell little."""

QUASI_DIRECT = (
    # The motor of Unitree's Go1 at a hip, as google-deepmind/mujoco_menagerie has it at 28ffb48
    # (unitree_go1/go1.xml); a knee has 1.5 times the gears: limit 35.55.
    Servo(name="GO1-HIP", kp=100.0, kv=2.0, limit=23.7, armature=0.01, friction=0.2),
    # Rated torque, no-load speed of 215 rev/min, gears 9:1 and rotor of 2600 g cm2: the ROS package
    # myactuator_rmd, class X8V2. Its gains are commands: full torque at 0.25 rad is assumed.
    Servo(name="RMD-X8", kp=36.0, kv=0.4, limit=9.0, armature=0.0211),
)
"""Modules with few gears, driven as position servos."""

SERVOS = (
    # kp, limit and armature: TheRobotStudio/SO-ARM100 at 53f2b75,
    # Simulation/SO101/joints_properties.xml. kv: see robots/so101/card.toml.
    Servo(name="STS3215", kp=17.8, kv=1.0, limit=3.35, armature=0.028),
    *DYNAMIXELS,
    *X_SERIES,
    *HOBBY,
    *QUASI_DIRECT,
)
"""Every servo known by name."""


def servo(name: str) -> Servo | None:
    """Return a servo by its name, or None if it is not one we know."""
    return next((known for known in SERVOS if known.name == name), None)
