"""Sections of the report of a scene: each a generator of an embedding and options that returns a Contribution."""
