"""One page that opens without a network: bodies that move, charts and tables beside them."""
