"""Hidden parameters of a body, inferred together with its states from a run or a few."""
