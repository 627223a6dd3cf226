"""Maps between bodies, from arrays and callables alone; the maps are still to come."""
