"""Maps between the states and the commands of two bodies, one file each."""
