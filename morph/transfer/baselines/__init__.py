"""What a transfer is compared with: other ways to use a source, and none."""
