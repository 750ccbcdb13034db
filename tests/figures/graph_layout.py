"""Where to put the dots of a graph's picture."""

import numpy as np


def spring_layout(n_nodes: int, links: np.ndarray, strength: np.ndarray, inner: np.ndarray) -> np.ndarray:
    """(N, 2) places of nodes on a page three wide and two high.

    Linked nodes attract each other (by ``strength`` (L,) of each of the ``links`` (L, 2)), all repel each other
    (Fruchterman and Reingold 1991); the distances that come of it are then evened out, so that dots do not cover
    each other. Nodes that are not ``inner`` (N,) bool are kept outside of those that are.
    """
    pull = np.zeros((n_nodes, n_nodes))
    np.maximum.at(pull, (links[:, 0], links[:, 1]), strength)
    pull = np.maximum(pull, pull.T)
    np.fill_diagonal(pull, 0)
    # Many links would draw everything into one clump.
    pull /= np.sqrt(np.outer(*[np.maximum(pull.sum(axis=1), 1)] * 2)) / 2
    rng = np.random.default_rng(1)
    places = rng.normal(size=(n_nodes, 2)) * 0.3
    places[~inner] *= 3
    length = 1 / np.sqrt(max(n_nodes, 1))
    for heat in np.geomspace(0.2, 0.002, 600):
        apart = places[:, None] - places
        distance = np.linalg.norm(apart, axis=2) + 1e-9
        force = length**2 / distance - pull * distance**2 / length
        np.fill_diagonal(force, 0)
        move = (apart / distance[..., None] * force[..., None]).sum(axis=1) - 0.3 * places
        size = np.linalg.norm(move, axis=1, keepdims=True) + 1e-9
        places = places + move / size * np.minimum(size, heat)
    return _spread(places, inner)


def _spread(places: np.ndarray, inner: np.ndarray) -> np.ndarray:
    """The same arrangement on the whole page, with a least distance between any two nodes."""
    middle = places[inner].mean(axis=0)
    away = places - middle
    # Radii by rank fill the page evenly; what lies outside the component gets the outer ranks.
    radius = np.linalg.norm(away, axis=1)
    order = np.lexsort((radius, ~inner))
    even = np.empty(len(places))
    even[order] = np.sqrt((np.arange(len(places)) + 0.5) / len(places))
    direction = away / np.maximum(radius, 1e-9)[:, None]
    places = direction * even[:, None] * [1.5, 1.0]
    gap = 1.25 * np.sqrt(np.pi * 1.5 / len(places)) * 0.75
    for _ in range(300):
        apart = places[:, None] - places
        distance = np.linalg.norm(apart, axis=2) + 1e-9
        np.fill_diagonal(distance, np.inf)
        push = np.maximum(gap - distance, 0) / distance / 2
        places = places + 0.5 * (apart * push[..., None]).sum(axis=1)
    return places
