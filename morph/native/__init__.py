"""C code of this project: compiled once, and loaded only where nobody else could change it."""
