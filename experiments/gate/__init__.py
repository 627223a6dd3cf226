"""The gate of the loop: is the model good enough? How often it is right, and how sure it is."""
