"""A policy adjusted so that a target does under it what the source did: thesis section 3.3."""
