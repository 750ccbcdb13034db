"""How results look: colours of the floor map, the walk as a curve, pictures of both."""
