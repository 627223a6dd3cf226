"""What the viewer costs: time, memory, and what it sends."""
