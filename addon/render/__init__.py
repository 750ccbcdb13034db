"""Results in the scene and over the viewport: the painted floor, walks as curves, boxes and lines."""
