"""Parts of the study of the cart-pole's policy on many bodies."""
