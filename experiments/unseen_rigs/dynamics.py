"""Robots by pinocchio: semi-implicit steps with contact, fluid, loops and rotors of their own.

Nothing here is MuJoCo's: forces of a floor are springs whose tangential part slides (Cundall and
Strack 1979, Geotechnique 29(1), 47-65), those of a fluid are pressure on the box of equal inertia,
loops are closed by multipliers with Baumgarte's stabilisation (1972, Comput. Methods Appl. Mech.
Eng. 1, 1-16), and a rotor turns freely between its teeth.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from experiments.unseen_rigs.plant import Moved, Plant
from morph.arrays import Array

STEP, PERIOD, RATE = 2e-4, 0.002, 100.0
"""Seconds a step and between two commands; readings a second."""
STIFF, DAMPED = 2e4, 60.0
"""Of the floor at one point: N/m and N s/m, along its normal and while it holds across it."""
CLOSING = 100.0
"""Rate at which a loop that has come apart closes, 1/s."""
TEETH = 2e3, 2.0
"""Of a gear's teeth: N m/rad and N m s/rad."""
DENSITY = 1000.0
"""Of water, kg/m3."""


Act = Callable[[float, Mapping[str, float], Mapping[str, float]], Mapping[str, float]]
"""Commands by the time, and positions and velocities of hinges by name."""


class Simulated:
    """A plant that moves."""

    def __init__(self, plant: Plant) -> None:
        """Build its model."""
        import pinocchio as pin

        self.pin, self.plant = pin, plant
        self.model = pin.buildModelFromMJCF(str(plant.description))
        if plant.wet:
            self.model.gravity.linear = np.zeros(3)
        if plant.carried is not None:
            joint, mass, place = plant.carried
            self.model.appendBodyToJoint(
                self.model.getJointId(joint),
                pin.Inertia(mass, np.zeros(3), np.zeros((3, 3))),
                pin.SE3(np.eye(3), np.array(place)),
            )
        if plant.gap is not None:
            # The rotor turns by itself.
            self.model.armature[self.model.joints[self._joint(plant.gap[0])].idx_v] = 0.0
        self.data = self.model.createData()
        names = list(self.model.names)[1:]
        self.hinges = {
            name: (joint.idx_q, joint.idx_v)
            for name, joint in zip(names, list(self.model.joints)[1:], strict=True)
            if joint.nv == 1
        }
        self.boxes = [_box(self.model, at) for at in range(1, self.model.njoints)]

    def _joint(self, name: str) -> int:
        return int(self.model.getJointId(name))

    def moved(self, act: Act, start: Array, seconds: float) -> Moved:
        """Return how it moves from rest.

        Args:
            act: Its controller, called every `PERIOD`.
            start: Its configuration, shape (nq,).
            seconds: How long.
        """
        pin, plant = self.pin, self.plant
        q, v = np.array(start, dtype=float), np.zeros(self.model.nv)
        anchors: dict[int, Array] = {}
        rotor = [0.0, 0.0] if plant.gap is None else [q[self.hinges[plant.gap[0]][0]], 0.0]
        steps, each, read = round(seconds / STEP), round(PERIOD / STEP), round(1 / RATE / STEP)
        told: Mapping[str, float] = {}
        commands, positions, efforts, spins, pulls = [], [], [], [], []
        pull = np.zeros(3)
        for at in range(steps + 1):
            if at % each == 0:
                told = act(
                    at * STEP,
                    {name: float(q[i]) for name, (i, _) in self.hinges.items()},
                    {name: float(v[i]) for name, (_, i) in self.hinges.items()},
                )
                commands.append(dict(told))
            torque, effort = self._torques(q, v, told, rotor)
            if at % read == 0:
                positions.append(q.copy())
                efforts.append({name: effort[i] for name, (_, i) in self.hinges.items()})
                spins.append(v[3:6].copy())
                pulls.append(pull / read)
                pull = np.zeros(3)
            if plant.loop is None:
                forces = self._forces(at * STEP, q, v, told, anchors)
                slope = pin.aba(self.model, self.data, q, v, torque, forces)
            else:
                slope = self._closed(q, v, torque)
            if self.model.joints[1].nv == 6:
                up = self.data.oMi[1].rotation.T @ self.model.gravity.linear
                pull += slope[:3] + _cross(v[3:6], v[:3]) - up
            v = v + STEP * slope
            q = pin.integrate(self.model, q, STEP * v)
        if not np.isfinite(q).all():
            raise ArithmeticError(f"{plant.description.name} diverges")
        return Moved(
            time=np.arange(len(positions)) / RATE,
            position=np.array(positions),
            spin=np.array(spins),
            pull=np.array(pulls),
            effort={name: np.array([each[name] for each in efforts]) for name in self.hinges},
            # A semi-implicit step is a leapfrog, whose force acts about its time.
            told_at=np.maximum(np.arange(len(commands)) * PERIOD - 0.5 * STEP, 0.0),
            told={name: np.array([each[name] for each in commands]) for name in commands[0]},
        )

    def _torques(
        self, q: Array, v: Array, told: Mapping[str, float], rotor: list[float]
    ) -> tuple[Array, Array]:
        """Return torques on the links and of the motors, and step a rotor between its teeth."""
        torque = np.zeros(self.model.nv)
        for name, value in told.items():
            if name in self.hinges:
                torque[self.hinges[name][1]] = self.plant.weak.get(name, 1.0) * value
        effort = torque.copy()
        for name, damping in self.plant.damping.items():
            torque[self.hinges[name][1]] -= damping * v[self.hinges[name][1]]
        if self.plant.gap is not None:
            joint, gap, inertia = self.plant.gap
            i, j = self.hinges[joint]
            ahead, faster = rotor[0] - q[i], rotor[1] - v[j]
            deep = ahead - np.clip(ahead, -0.5 * gap, 0.5 * gap)
            felt = (TEETH[0] * deep + TEETH[1] * faster) * (deep != 0.0)
            # Teeth push and do not pull.
            felt = felt if felt * deep > 0.0 else 0.0
            rotor[1] += STEP * (torque[j] - felt) / inertia
            rotor[0] += STEP * rotor[1]
            torque[j] = felt
        return torque, effort

    def _forces(
        self,
        t: float,
        q: Array,
        v: Array,
        told: Mapping[str, float],
        anchors: dict[int, Array],
    ) -> Any:
        """Return what acts on each joint's link, in its frame."""
        pin, plant, data = self.pin, self.plant, self.data
        total = [np.zeros(6) for _ in range(self.model.njoints)]
        pin.forwardKinematics(self.model, data, q, v)

        def add(joint: int, place: Array, force: Array) -> None:
            total[joint] += np.concatenate([force, _cross(place, force)])

        for number, foot in enumerate(plant.feet):
            joint, place = self._joint(foot.joint), np.array(foot.place)
            turn = data.oMi[joint].rotation
            # The lowest point of the ball.
            place = place - foot.radius * turn[2]
            world = data.oMi[joint].act(place)
            if world[2] >= 0.0:
                anchors.pop(number, None)
                continue
            speed = turn @ (data.v[joint].linear + _cross(data.v[joint].angular, place))
            press = max(0.0, -STIFF * world[2] - DAMPED * speed[2])
            anchor = anchors.setdefault(number, world[:2].copy())
            across = -STIFF * (world[:2] - anchor) - DAMPED * speed[:2]
            size, most = float(np.linalg.norm(across)), foot.mu * press
            if size > most:
                across *= most / size
                anchors[number] = world[:2] + (across + DAMPED * speed[:2]) / STIFF
            add(joint, place, turn.T @ np.append(across, press))
        for name, (force, where, link) in plant.motors.items():
            add(self._joint(link), where, plant.weak.get(name, 1.0) * told[name] * force)
        for link, (middle, drag) in plant.drag.items():
            at = self._joint(link)
            through = data.v[at].linear + _cross(data.v[at].angular, middle)
            add(at, middle, -drag * through * abs(through))
        if plant.push is not None and plant.push.start <= t < plant.push.end:
            add(
                1, self.model.inertias[1].lever, data.oMi[1].rotation.T @ np.array(plant.push.force)
            )
        if plant.wet:
            for at in range(1, self.model.njoints):
                total[at] += self._pressure(at)
        result = pin.StdVec_Force()
        result.extend([pin.Force(each) for each in total])
        return result

    def _pressure(self, at: int) -> Array:
        """Return what water does to a link, shape (6,), in its frame.

        Source: MuJoCo documentation, Computation, Passive forces, inertia model.
        """
        (turn, edges), lever = self.boxes[at - 1], self.model.inertias[at].lever
        speed, spin = self.data.v[at].linear, self.data.v[at].angular
        u, w = turn.T @ (speed + _cross(spin, lever)), turn.T @ spin
        x, y, z = edges
        force = -0.5 * DENSITY * np.array([y * z, x * z, x * y]) * u * abs(u)
        fourth = np.array([x * (y**4 + z**4), y * (x**4 + z**4), z * (x**4 + y**4)])
        moment = -DENSITY / 64.0 * fourth * w * abs(w)
        force, moment = turn @ force, turn @ moment
        return np.concatenate([force, moment + _cross(lever, force)])

    def _closed(self, q: Array, v: Array, torque: Array) -> Array:
        """Return accelerations of a plant with a loop."""
        pin, model, data = self.pin, self.model, self.data
        one, here, other, there = self.plant.loop or ("", np.zeros(3), "", np.zeros(3))
        mass = pin.crba(model, data, q)
        mass = np.triu(mass) + np.triu(mass, 1).T
        bias = pin.nonLinearEffects(model, data, q, v)
        pin.computeJointJacobians(model, data, q)
        pin.forwardKinematics(model, data, q, v, np.zeros(model.nv))
        apart, rate, drift, rows = np.zeros(3), np.zeros(3), np.zeros(3), np.zeros((3, model.nv))
        for name, place, sign in ((one, here, 1.0), (other, there, -1.0)):
            joint = self._joint(name)
            turn, moving, slope = data.oMi[joint].rotation, data.v[joint], data.a[joint]
            through = moving.linear + _cross(moving.angular, place)
            apart += sign * data.oMi[joint].act(place)
            rate += sign * turn @ through
            drift += sign * (
                turn
                @ (slope.linear + _cross(slope.angular, place) + _cross(moving.angular, through))
            )
            local = pin.getJointJacobian(model, data, joint, pin.LOCAL)
            rows += sign * turn @ (local[:3] - _skew(place) @ local[3:])
        free = np.linalg.solve(mass, torque - bias)
        wanted = -drift - 2.0 * CLOSING * rate - CLOSING**2 * apart
        pull = np.linalg.solve(mass, rows.T)
        # Of a plane loop one row is empty.
        multiplier = np.linalg.lstsq(rows @ pull, wanted - rows @ free, rcond=1e-9)[0]
        return np.asarray(free + pull @ multiplier)


def _cross(a: Array, b: Array) -> Array:
    # NumPy's takes ten times as long of three numbers.
    return np.array(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )


def _skew(place: Array) -> Array:
    x, y, z = place
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def _box(model: Any, at: int) -> tuple[Array, Array]:
    """Return the principal axes, as columns, and edges of the box of a link's inertia."""
    inertia = model.inertias[at]
    moments, turn = np.linalg.eigh(inertia.inertia)
    edges = np.sqrt(np.maximum(6.0 * (moments.sum() - 2.0 * moments) / inertia.mass, 0.0))
    return turn, edges
