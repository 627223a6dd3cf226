"""Plans inside a simulator: where they rest, how they begin, and which of them stays."""
