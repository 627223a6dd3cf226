"""A batch of simulations as effects see it before each step."""

from __future__ import annotations

from collections.abc import Mapping, MutableSequence, Sequence
from typing import Any

import mujoco
import numpy as np
from mujoco.batch import MODEL_FIELDS, Batch

from morph.arrays import Array
from morph.body.actuators import driven_joint, strength
from morph.errors import SimulationFailed
from morph.physics.effect import Effect

FIXED, AFFINE = int(mujoco.mjtGain.mjGAIN_FIXED), int(mujoco.mjtGain.mjGAIN_AFFINE)
BARE, LINEAR = int(mujoco.mjtBias.mjBIAS_NONE), int(mujoco.mjtBias.mjBIAS_AFFINE)
MEMORYLESS = int(mujoco.mjtDyn.mjDYN_NONE)


class Rows:
    """What effects see and touch of a batch before a step; see `Simulations`."""

    def __init__(self, batch: Batch, step: float) -> None:
        """Bind the batch's positions, velocities, commands and applied forces."""
        self.step = step
        self._batch, self._model = batch, batch.model
        self._position, self._velocity = batch.bind("qpos"), batch.bind("qvel")
        self._control, self._applied = batch.bind("ctrl"), batch.bind("qfrc_applied")
        model = self._model
        joints = [driven_joint(model, index) for index in range(model.nu)]
        self.actuators: Mapping[str, str | None] = {
            model.actuator(index).name: None if joint is None else model.joint(joint).name
            for index, joint in enumerate(joints)
        }
        # Fields of the model that effects write, with what they are without them.
        self._fields: dict[str, tuple[Array, Array]] = {}
        self._known: dict[str, Array] = {}
        self._efforts: dict[str, tuple[Array, Array]] = {}
        self._detached: set[str] = set()
        self._pushes: Array | None = None

    def act(self, effects: Sequence[Effect], states: MutableSequence[Any]) -> None:
        """Let effects act on the coming step, and keep what each remembers in `states`."""
        self._applied[:] = 0.0
        self._efforts.clear()
        for view, plain in self._fields.values():
            view[:] = plain
        if self._pushes is not None:
            self._pushes[:] = 0.0
        for slot in sorted(range(len(effects)), key=lambda at: effects[at].kind != "actuator"):
            states[slot] = effects[slot].before_step(self, states[slot])
        for name, (effort, nominal) in self._efforts.items():
            joint = self.actuators[name]
            if joint is None:
                whole = np.divide(effort, nominal, np.ones_like(effort), where=nominal != 0.0)
                self._scale(name, whole)
            else:
                self.force(joint)[:] += effort - nominal
        if "dof_armature" in self._fields:
            # MuJoCo keeps the inertia of joints that turn alone here too.
            (changed, plain), (whole, before) = (
                self._fields[name] for name in ("dof_armature", "dof_M0")
            )
            whole[:] = before + (changed - plain)

    def position(self, joint: str) -> Array:
        """Return a joint's position, shape (rows,)."""
        return np.asarray(self._position[:, self._model.joint(joint).qposadr[0]])

    def velocity(self, joint: str) -> Array:
        """Return a joint's velocity, shape (rows,)."""
        return np.asarray(self._velocity[:, self._dof(joint)])

    def force(self, joint: str) -> Array:
        """Return the view to which a joint's generalized forces are added."""
        return np.asarray(self._applied[:, self._dof(joint)])

    def control(self, actuator: str) -> Array:
        """Return what an actuator receives for the step, shape (rows,)."""
        return np.asarray(self._control[:, self._model.actuator(actuator).id])

    def drive_speed(self, actuator: str) -> Array:
        """Return the speed of an actuator's joint, shape (rows,); zero without one."""
        joint = self.actuators[actuator]
        return np.zeros_like(self.control(actuator)) if joint is None else self.velocity(joint)

    def effort(self, actuator: str) -> Array:
        """Return the view of what an actuator produces at its joint, shape (rows,)."""
        if actuator not in self._efforts:
            joint = self.actuators[actuator]
            place = self.drive_speed(actuator) if joint is None else self.position(joint)
            made = self.torque(actuator, place, self.drive_speed(actuator))
            nominal = np.zeros_like(made) if actuator in self._detached else made.copy()
            self._efforts[actuator] = made, nominal
        return self._efforts[actuator][0]

    def torque(self, actuator: str, position: Array, velocity: Array) -> Array:
        """Return what an actuator would produce with its joint there, shape (rows,).

        Raises:
            SimulationFailed: It has a state of its own, or a law that only MuJoCo knows.
        """
        at = self._model.actuator(actuator).id
        gain, bias = self._of("actuator_gainprm")[:, at], self._of("actuator_biasprm")[:, at]
        kinds = self._model.actuator_gaintype[at], self._model.actuator_biastype[at]
        plain = kinds[0] in (FIXED, AFFINE) and kinds[1] in (BARE, LINEAR)
        joint = self.actuators[actuator]
        if joint is None:
            plain = kinds == (FIXED, BARE)
        if not plain or self._model.actuator_dyntype[at] != MEMORYLESS:
            raise SimulationFailed(
                f"the torque of {actuator} follows from more than command, position and speed",
                where=f"actuator {actuator} under an effect that changes its torque",
                fix="describe it as a motor or a servo of a joint without activation, or leave out "
                "the effect",
            )
        gear = self._of("actuator_gear")[:, at, 0]
        if joint is None:
            gear = np.full_like(gear, strength(self._model, at))
        command, length, rate = self.control(actuator), gear * position, gear * velocity
        if self._model.actuator_ctrllimited[at]:
            command = np.clip(command, *self._of("actuator_ctrlrange")[:, at].T)
        force = gain[:, 0] * command
        if kinds[0] == AFFINE:
            force = force + (gain[:, 1] * length + gain[:, 2] * rate) * command
        if kinds[1] == LINEAR:
            force = force + bias[:, 0] + bias[:, 1] * length + bias[:, 2] * rate
        if self._model.actuator_forcelimited[at]:
            force = np.clip(force, *self._of("actuator_forcerange")[:, at].T)
        made = gear * force
        turned = None if joint is None else self._model.joint(joint).id
        if turned is not None and self._model.jnt_actfrclimited[turned]:
            # Exact where one actuator drives the joint; of two, each is clipped.
            made = np.clip(made, *self._of("jnt_actfrcrange")[:, turned].T)
        return np.asarray(made)

    def detach(self, actuator: str) -> None:
        """Take an actuator off its joint for good: only what `effort` is told is left."""
        if actuator in self._detached:
            return
        at = self._model.actuator(actuator).id
        for name in ("actuator_gainprm", "actuator_biasprm"):
            self._of(name)
            self._expanded(name)[:, at] = 0.0
        if actuator in self._efforts:
            self._efforts[actuator][1][:] = 0.0
        self._detached.add(actuator)

    def friction(self, joint: str) -> Array:
        """Return the view of the dry friction that a joint holds with, shape (rows,)."""
        return np.asarray(self._field("dof_frictionloss")[:, self._dof(joint)])

    def armature(self, joint: str) -> Array:
        """Return the view of the inertia that turns with a joint, shape (rows,)."""
        self._field("dof_M0")
        return np.asarray(self._field("dof_armature")[:, self._dof(joint)])

    def push(self, body: str) -> Array:
        """Return the view of the force at a body's centre of mass, N, shape (rows, 3)."""
        if self._pushes is None:
            self._pushes = self._batch.bind("xfrc_applied")
        return np.asarray(self._pushes[:, self._model.body(body).id, :3])

    def _scale(self, actuator: str, factor: Array) -> None:
        """Scale the force of an actuator for a step, with its limits."""
        at = self._model.actuator(actuator).id
        for name in ("actuator_gainprm", "actuator_forcerange"):
            self._field(name)[:, at] *= factor[:, None]

    def _dof(self, joint: str) -> int:
        return int(self._model.joint(joint).dofadr[0])

    def _field(self, name: str) -> Array:
        if name not in self._fields:
            view = self._expanded(name)
            self._fields[name] = view, view.copy()
        return self._fields[name][0]

    def _of(self, name: str) -> Array:
        """Return a field of every row's model as it was before any effect, (rows, ...)."""
        if name not in self._known:
            models = self._batch.models
            if isinstance(models, tuple):
                self._known[name] = np.stack([getattr(model, name) for model in models])
            else:
                own = None if models else self._batch.expanded(name)
                one = np.asarray(getattr(models or self._model, name))
                self._known[name] = one[None].copy() if own is None else own.copy()
        return self._known[name]

    def _expanded(self, name: str) -> Array:
        """Return the live view of a model's field, (rows, ...).

        A batch has such views only while it runs on its own model: what sets the rows'
        models apart is written into it first.
        """
        models = self._batch.models
        if models is not None:
            rows = models if isinstance(models, tuple) else (models,) * self._batch.nsim
            distinct = {id(model): model for model in rows}
            self._batch.set_models(None)
            for field in MODEL_FIELDS:
                # A view of the model's one copy serves all rows that share a model.
                values = {key: _value(model, field) for key, model in distinct.items()}
                own = _value(self._model, field)
                if any(not np.array_equal(value, own) for value in values.values()):
                    self._batch.expand(field)[:] = np.stack([values[id(m)] for m in rows])
        return np.asarray(self._batch.expand(name))


def _value(model: Any, field: str) -> Array:
    part = model.opt if field.startswith("opt.") else model
    return np.asarray(getattr(part, field.removeprefix("opt.")))
