"""Linear models with normal noise: states, unknowns, filter, normal equations and evidence."""
