"""From the meshes of a body to parts on a plate; the parts are still to come.

Write `from print.x import y`: a plain import of this package hides the builtin.
"""
