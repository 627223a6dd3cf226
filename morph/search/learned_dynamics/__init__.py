"""A model learned from trials, and plans made inside of it."""
