"""Kin: bodies drawn about those of the shelf, and policies carried between them in many ways."""
