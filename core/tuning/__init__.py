"""Making an embedding smaller without losing what it is good for."""
