"""Parts of the study of manifold alignment."""
