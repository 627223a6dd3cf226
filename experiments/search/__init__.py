"""What the benchmark of searches measures."""
