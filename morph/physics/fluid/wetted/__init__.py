"""The surface of a link that water touches: a clean solid, a wrap, a hull or a box."""
