"""The parts of the view that holds a recording against its simulation."""
