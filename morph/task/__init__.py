"""Tasks: what a body is to do, what it costs, and when it is done."""
