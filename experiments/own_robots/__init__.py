"""Robots that nobody here wrote, through every command."""
