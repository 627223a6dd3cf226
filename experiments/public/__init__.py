"""Public data sets: what they hold, where they come from, and how to have them."""
