"""The simulator: a robot under effects, one run or many at once."""
