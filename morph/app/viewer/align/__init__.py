"""What an alignment or a transfer found, as bodies with lines between their parts."""
