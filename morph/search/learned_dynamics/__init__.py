"""Dynamics learned from trials, and planning in them."""
