"""Added-mass tensors: of closed meshes by boundary elements, of ellipsoids, boxes and rods."""

from morph.physics.fluid.tensor.box import box_tensor as box_tensor
from morph.physics.fluid.tensor.ellipsoid import ellipsoid_tensor as ellipsoid_tensor
from morph.physics.fluid.tensor.extrapolate import extrapolated as extrapolated
from morph.physics.fluid.tensor.kirchhoff import kirchhoff as kirchhoff
from morph.physics.fluid.tensor.rod import rod_tensor as rod_tensor
from morph.physics.fluid.tensor.solid import tensor_of_solid as tensor_of_solid
from morph.physics.fluid.tensor.tensor import Tensor as Tensor
