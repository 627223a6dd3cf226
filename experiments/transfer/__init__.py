"""What the studies of transfer share."""
