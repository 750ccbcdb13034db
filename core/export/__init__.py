"""Embeddings for other programs: game engines and crowd tools that walk and plan without this package."""
