"""Effects of what surrounds every body."""
