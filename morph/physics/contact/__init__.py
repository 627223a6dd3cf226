"""Effects where two bodies touch: friction, softness, restitution; and named floors."""
