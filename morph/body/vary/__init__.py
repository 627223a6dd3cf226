"""Variation of a body: operations that are data, and paths from one body to another."""

from __future__ import annotations

from morph.body.vary.add import Add as Add
from morph.body.vary.apply import removed as removed
from morph.body.vary.apply import vary as vary
from morph.body.vary.design import from_vector as from_vector
from morph.body.vary.design import sweep as sweep
from morph.body.vary.design import tunable as tunable
from morph.body.vary.design import with_parameters as with_parameters
from morph.body.vary.drop import Drop as Drop
from morph.body.vary.heavier import Heavier as Heavier
from morph.body.vary.interpolate import interpolate as interpolate
from morph.body.vary.interpolate import path as path
from morph.body.vary.lock import Lock as Lock
from morph.body.vary.operation import Operation as Operation
from morph.body.vary.operations import OPERATIONS as OPERATIONS
from morph.body.vary.operations import operation_of as operation_of
from morph.body.vary.scale import Scale as Scale
from morph.body.vary.stiffen import Stiffen as Stiffen
