"""Effects of what a link weighs and where."""
