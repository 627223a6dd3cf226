"""What `morph` gives a program: the commands as functions, which return what commands print."""
