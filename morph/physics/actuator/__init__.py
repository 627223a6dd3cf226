"""Effects on what an actuator makes of its commands."""
