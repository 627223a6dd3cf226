"""Meshes: their geometry, the facts that follow from it, and the files that hold them."""

from morph.body.mesh.read import mesh_content as mesh_content
from morph.body.mesh.read import read_mesh as read_mesh
from morph.body.mesh.solid import Mesh as Mesh
from morph.body.mesh.thin import thinned as thinned
from morph.body.mesh.write import as_obj as as_obj
from morph.body.mesh.write import as_stl as as_stl
