"""A learned model of a body's accelerations, its outputs joined by one physical kernel."""
