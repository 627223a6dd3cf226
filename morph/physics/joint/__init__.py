"""Effects on the motion of a joint."""
