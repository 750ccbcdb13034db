"""The motion graph unrolled into the grid and reduced to its largest strongly connected component."""
