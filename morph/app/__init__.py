"""The doors: what a user meets at the terminal and in the browser."""
