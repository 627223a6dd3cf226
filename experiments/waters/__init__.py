"""Six fluids and ballasts of the hexapod swimmer, and runs in them."""
