"""Robots and dynamics of which no part is MuJoCo's or the shelf's, diagnosed."""
