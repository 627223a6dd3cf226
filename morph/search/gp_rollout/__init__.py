"""What is believed of a learned body's future, and policies improved on it."""
