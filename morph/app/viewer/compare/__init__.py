"""What the view that compares bodies is made of."""
