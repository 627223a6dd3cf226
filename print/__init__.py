"""From the meshes of a body to parts on a plate; lengths are millimetres, always.

Write `from print.x import y`: a plain import of this package hides the builtin.
"""
