"""Walks through an embedding, and the poses that play them."""
