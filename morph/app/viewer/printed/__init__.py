"""What the view Print works with."""
