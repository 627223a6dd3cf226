"""Bodies: the shelf, its descriptions and cards, and what runs them."""
