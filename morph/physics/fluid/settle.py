"""What MuJoCo computes once from the inertia at rest, computed again with the fluid in it."""

from __future__ import annotations

import mujoco
import numpy as np

from morph.arrays import Array
from morph.physics.fluid.kernel import flowing, install
from morph.physics.fluid.options import put_right
from morph.physics.fluid.reference import wet_bodies


def settle(model: mujoco.MjModel) -> mujoco.MjModel:
    """Return a compiled model, made ready for its fluid if it has any.

    MuJoCo sizes the softness of contacts and limits by each part's inverse inertia at `qpos0`,
    which it computes without callbacks: in water contacts would be up to ten times too soft.
    After `mj_setConst` or a change of `body_user` call this again.

    Raises:
        EffectError: The description asks MuJoCo for what would leave the fluid out.
    """
    if len(wet_bodies(model)):
        put_right(model)
        with flowing(model):
            _write_inverse_weights(model)
    return model


def batches(model: mujoco.MjModel) -> bool:
    """Return whether a model can run in `mujoco.batch`: it is dry, or its fluid is compiled."""
    return not len(wet_bodies(model)) or install()


def _write_inverse_weights(model: mujoco.MjModel) -> None:
    """Write the mean inverse inertia of each body, degree of freedom and tendon.

    Source: MuJoCo documentation, Computation, Constraint model: the diagonal of J inv(M) J'
    at `qpos0`, averaged over the three axes of a body's translation and rotation.
    """
    data = mujoco.MjData(model)
    mujoco.mj_resetData(model, data)
    mujoco.mj_forward(model, data)
    inverse = np.empty((model.nv, model.nv))
    mujoco.mj_solveM(model, data, inverse, np.eye(model.nv))
    for body in range(1, model.nbody):
        if not np.any(model.body_invweight0[body]):
            continue
        jacobian = np.zeros((6, model.nv))
        mujoco.mj_jacBodyCom(model, data, jacobian[:3], jacobian[3:], body)
        diagonal = np.einsum("ij,jk,ik->i", jacobian, inverse, jacobian)
        model.body_invweight0[body] = diagonal[:3].mean(), diagonal[3:].mean()
    model.dof_invweight0[:] = _of_joints(model, np.diag(inverse))
    for tendon in range(model.ntendon):
        row = _tendon(model, data, tendon)
        model.tendon_invweight0[tendon] = row @ inverse @ row


def _of_joints(model: mujoco.MjModel, diagonal: Array) -> Array:
    mean = diagonal.copy()
    sizes = {mujoco.mjtJoint.mjJNT_FREE.value: (3, 3), mujoco.mjtJoint.mjJNT_BALL.value: (3,)}
    for joint in range(model.njnt):
        first = model.jnt_dofadr[joint]
        for size in sizes.get(int(model.jnt_type[joint]), (1,)):
            mean[first : first + size] = diagonal[first : first + size].mean()
            first += size
    return mean


def _tendon(model: mujoco.MjModel, data: mujoco.MjData, tendon: int) -> Array:
    row = np.zeros(model.nv)
    first, count = model.ten_J_rowadr[tendon], model.ten_J_rownnz[tendon]
    row[model.ten_J_colind[first : first + count]] = data.ten_J[first : first + count]
    return row
