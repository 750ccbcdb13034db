"""The scene as the embedding sees it: a grid of task coordinates, obstacles and annotated regions."""
