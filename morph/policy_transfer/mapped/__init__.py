"""From a map between two bodies and a few transitions to feedback for the second."""
