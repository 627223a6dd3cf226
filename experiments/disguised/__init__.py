"""Bodies in disguise: hidden maps of states and commands, to be found again."""
