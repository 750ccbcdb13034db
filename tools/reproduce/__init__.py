"""Section 5 of the paper with our own code: one file for each group of figures."""

from .main import main

__all__ = ["main"]
