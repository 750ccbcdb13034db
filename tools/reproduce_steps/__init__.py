"""Section 5 of the paper with our own code: one file for each group of figures. No part of the panel's workflow."""
