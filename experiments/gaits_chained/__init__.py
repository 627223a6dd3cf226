"""What the study of chains of gaits is made of."""
