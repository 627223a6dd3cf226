"""Xacro, the macros of URDF, from strangers: checked, then expanded in a process of its own."""

from morph.body.xacro.process import expand as expand
from morph.body.xacro.process import read as read
