"""Policies carried to another body: the loop, live targets, and the link to a service."""
