"""The parts of the view Design."""
