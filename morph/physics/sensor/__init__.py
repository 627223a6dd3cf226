"""Effects on what a sensor says."""
