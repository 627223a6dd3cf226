"""Policies: what tells a body's actuators what to do, on disk and in memory."""
