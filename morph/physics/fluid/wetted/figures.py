"""What a fluid needs to know of a link: its tensor, its volume and its drag, computed once."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from morph.arrays import Array
from morph.body.mesh import Mesh
from morph.errors import RobotError
from morph.physics.fluid.tensor import Tensor, box_tensor, tensor_of_solid
from morph.physics.fluid.tensor.box import THINNEST
from morph.physics.fluid.tensor.manifold import refined
from morph.physics.fluid.tensor.solid import positive
from morph.physics.fluid.wetted.alike import form_of
from morph.physics.fluid.wetted.choose import check_shapes, surface
from morph.physics.fluid.wetted.keep import kept
from morph.physics.fluid.wetted.mend import mended
from morph.physics.fluid.wetted.outcome import Wetted
from morph.physics.fluid.wetted.panels import panel_drag
from morph.physics.fluid.wetted.round import round_tensor

ROUGH, MORE = 0.05, 2560
"""Error from which on a tensor is worked out again, on as many panels."""

STRIPS = 24
"""Panels along the greatest extent, at the least, over which drag is summed."""


@dataclass(frozen=True, kw_only=True)
class Figures:
    """What a fluid needs to know of a link, in the link's frame and at unit density."""

    tensor: Tensor
    """Added mass about the frame's origin, with the volume displaced and its centre."""
    drag: Array
    """Quadratic drag along and about the frame's axes through that centre, shape (6,)."""
    how: str
    """What stands for the link: its own `mesh`, a `wrap` of it, its `hull`, or a `box`."""
    reason: str
    """Why it is not the link's shapes as they are; empty if it is."""
    spread: Array
    """By how much added mass along and about the axes differs among what might stand for it,
    as a part, shape (2,); 0 if that is clear."""

    def scaled(self, factor: float) -> Figures:
        """Return the figures of the body grown by a factor about the frame's origin."""
        # A force goes as area and speed squared; a torque as that times the arm cubed.
        return replace(
            self,
            tensor=self.tensor.scaled(factor),
            drag=self.drag * np.repeat([factor**2, factor**5], 3),
        )


def figures_of(
    shapes: tuple[Mesh, ...], *, how: str = "mesh", where: str = "the shapes"
) -> Figures:
    """Return what a fluid needs to know of a body made of shapes.

    Worked out once for all bodies of one form, wherever they lie and mirrored or
    not, and kept by its content. What boundary elements refuse is mended, then
    replaced by its hull, then by a box, and the reason says so.

    Args:
        shapes: Triangle meshes in the link's frame, m; open, torn or inside out if need be.
        how: `mesh`, `hull` or `box`.
        where: What to call the body in an error.

    Raises:
        RobotError: There is no shape, a corner is not a number, or nothing is enclosed.
    """
    check_shapes(shapes, how, where)
    form = form_of(tuple(shape for shape in shapes if len(shape.faces)))
    result = kept((how, *form.content), lambda: _computed(form.shapes, how, where))
    centre = np.asarray(result["centre"], dtype=np.float64).reshape(3)
    tensor = Tensor(
        matrix=np.asarray(result["matrix"], dtype=np.float64).reshape(6, 6),
        volume=float(result["volume"]),
        centre=centre,
        error=float(result["error"]),
        panels=int(result["panels"]),
    )
    return Figures(
        tensor=tensor.mirrored(form.signs).shifted(form.middle),
        drag=result["drag"],
        how=str(result["how"]),
        reason=str(result["reason"]),
        spread=result["spread"],
    )


def _computed(shapes: tuple[Mesh, ...], how: str, where: str) -> dict[str, Array | float | str]:
    result = surface(shapes, how=how, where=where)
    try:
        tensor = _tensor(result)
    except RobotError:
        result, tensor = _instead(shapes, how, where)
    mesh = Mesh(vertices=result.vertices, faces=result.faces)
    fine = refined(mesh, float(np.ptp(mesh.bounds, axis=0).max()) / STRIPS)
    return {
        "matrix": tensor.matrix,
        "centre": tensor.centre,
        "volume": tensor.volume,
        "error": tensor.error,
        "panels": float(tensor.panels),
        "drag": panel_drag(fine.vertices, fine.faces, point=result.centre),
        "how": result.how,
        "reason": result.reason,
        "spread": np.zeros(2) if result.spread is None else result.spread.reshape(2, 3).max(axis=1),
    }


def _instead(shapes: tuple[Mesh, ...], how: str, where: str) -> tuple[Wetted, Tensor]:
    """Return what stands for shapes of whose own surface there is no tensor."""
    fault = "boundary elements found no panels on which it does not cross itself"
    for way in dict.fromkeys((how, "hull")):
        result = mended(shapes, fault, how=way, where=where)
        try:
            return result, _tensor(result)
        except RobotError:
            continue
    result = mended(shapes, fault, how="box", where=where)
    return result, _tensor(result)


def _tensor(result: Wetted) -> Tensor:
    """Return a surface's tensor about the origin: in closed form, by symmetry or by panels."""
    mesh = Mesh(vertices=result.vertices, faces=result.faces)
    if result.box is not None:
        # Water flows round a sheet thinner than this as round this.
        sides = np.maximum(result.box.sides, 1.001 * THINNEST * result.box.sides.max())
        whole = box_tensor(*sides.tolist()).turned(result.box.axes).shifted(result.box.centre)
    else:
        whole = round_tensor(mesh) or _by_panels(mesh)
    size = np.concatenate([np.ones(3), np.diag(mesh.inertia) / mesh.volume])
    about = whole.about(result.centre).matrix
    return Tensor(
        matrix=positive(about, result.volume * size),
        volume=result.volume,
        centre=result.centre,
        point=result.centre,
        error=whole.error,
        panels=whole.panels,
    ).about((0.0, 0.0, 0.0))


def _by_panels(mesh: Mesh) -> Tensor:
    tensor = tensor_of_solid(mesh.vertices, mesh.faces)
    if tensor.error < ROUGH:
        return tensor
    # Slender parts need more: some seconds, once.
    return tensor_of_solid(mesh.vertices, mesh.faces, panels=MORE)
