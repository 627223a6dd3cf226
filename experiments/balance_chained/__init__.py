"""What the study of the chain of balance says of its finished cases."""
