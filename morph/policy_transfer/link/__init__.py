"""A policy that keeps adapting although the way to its service is often closed."""
