"""Measures of embeddings: variability, coverage, weak spots, times to reach, occupancy and more."""
