"""Everything that goes into the work: clips, shapes and settings as arrays and values, and signs of their changes."""
