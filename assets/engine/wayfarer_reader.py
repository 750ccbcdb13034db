"""Reference reader of Wayfarer's engine format: loads an embedding, walks at random, plans, lays out the root's path.

Needs Python 3.8 and NumPy, nothing else. The format is described in docs/engine_format.md. A node is a tuple (x, y,
heading, segment): the character stands in cell (x, y), faces ``heading`` * 360 degrees / number of headings, and has
just played ``segment``. On a tiled ground x and y may go on beyond the grid.

    embedding = Embedding("folder")
    walk = embedding.random_walk(embedding.any_node(rng), 60.0, rng)
    times = embedding.times_to(cells)
    walk = embedding.shortest_walk(start, times)
    frames = embedding.root_path(walk)

Run it: python wayfarer_reader.py FOLDER. read_table reads the same nodes and links as a plain table, if there is one.
"""

import hashlib
import heapq
import io
import json
import math
import sys
import zipfile
import zlib
from pathlib import Path

import numpy as np

UNSOUND = (ValueError, LookupError, TypeError, AttributeError, RecursionError, EOFError, zipfile.BadZipFile, zlib.error)
"""What Embedding raises for files that are none of ours, or damaged."""


class Damaged(ValueError):
    pass


class Embedding:
    def __init__(self, folder):
        folder = Path(folder)
        header = read_header(folder)
        raw = read_file(folder / "embedding.npz")
        if hashlib.sha256(raw).hexdigest() != header["sha256"]:
            raise Damaged(f"'{folder / 'embedding.npz'}' does not belong to its header, or is damaged")
        for name, values in read_arrays(raw).items():
            setattr(self, name, values)
        self.header, self.segments, grid = header, header["segments"], header["grid"]
        self.nx, self.ny, self.n_headings = grid["shape"]
        self.cell_size, self.tiled, self.origin = grid["cell_size"], grid["tiled"], np.array(grid["origin"])
        self.n_frames = [segment["frames"] - 1 for segment in self.segments]
        n_segments, n_bytes = len(self.segments), (self.nx * self.ny + 7) // 8
        used = np.concatenate([self.follow.ravel(), self.stencil[:, 0]])
        if (
            self.nodes.shape != (n_segments * self.n_headings, n_bytes)
            or self.valid.shape != (len(self.stencil), n_bytes)
            or np.any((used < 0) | (used >= n_segments))
        ):
            raise Damaged(f"the arrays in '{folder}' do not fit their header")
        #: Stencils by the segment that they play and the heading that they start from, and those that arrive.
        self.leaving, self.arriving = {}, {}
        for k, (segment, heading, _, _, turn) in enumerate(self.stencil.tolist()):
            self.leaving.setdefault((segment, heading), []).append(k)
            self.arriving.setdefault((segment, (heading + turn) % self.n_headings), []).append(k)
        self.children, self.parents = ([[] for _ in self.segments] for _ in range(2))
        for before, after in self.follow.tolist():
            self.children[before].append(after)
            self.parents[after].append(before)

    def cell(self, x, y):
        """Number of a cell, None off the ground."""
        if self.tiled:
            return x % self.nx * self.ny + y % self.ny
        return x * self.ny + y if 0 <= x < self.nx and 0 <= y < self.ny else None

    def is_node(self, node):
        x, y, heading, segment = node
        cell = self.cell(x, y)
        if cell is None:
            return False
        return bool(self.nodes[segment * self.n_headings + heading][cell >> 3] >> (cell & 7) & 1)

    def is_valid(self, k, x, y):
        """Whether stencil k may be played from a cell: nothing stands in its way."""
        cell = self.cell(x, y)
        return cell is not None and bool(self.valid[k][cell >> 3] >> (cell & 7) & 1)

    def all_nodes(self):
        """(n, 4) int array of all nodes."""
        bits = np.unpackbits(self.nodes, axis=1, bitorder="little", count=self.nx * self.ny)
        plane, cell = np.nonzero(bits)
        segment, heading = np.divmod(plane, self.n_headings)
        return np.column_stack([*np.divmod(cell, self.ny), heading, segment])

    def any_node(self, rng):
        nodes = self.all_nodes()
        return tuple(nodes[rng.integers(len(nodes))].tolist())

    def end(self, node, k):
        """Where stencil k leads from a node."""
        segment, heading, dx, dy, turn = self.stencil[k].tolist()
        return node[0] + dx, node[1] + dy, (heading + turn) % self.n_headings, segment

    def links_from(self, node):
        """All (stencil, node) that a link leads to from a node; never empty."""
        x, y, heading, segment = node
        links = []
        for child in self.children[segment]:
            for k in self.leaving.get((child, heading), ()):
                end = self.end(node, k)
                if self.is_valid(k, x, y) and self.is_node(end):
                    links.append((k, end))
        return links

    def links_to(self, node):
        """All (stencil, node) that a link leads from to a node; never empty."""
        x, y, heading, segment = node
        links = []
        for k in self.arriving.get((segment, heading), ()):
            _, start_heading, dx, dy, _ = self.stencil[k].tolist()
            if self.is_valid(k, x - dx, y - dy):
                starts = ((x - dx, y - dy, start_heading, parent) for parent in self.parents[segment])
                links += [(k, start) for start in starts if self.is_node(start)]
        return links

    def random_walk(self, start, seconds, rng):
        """[(stencil, node), ...] after ``start``: at least so many seconds, each link with the same probability."""
        walk, node, frames = [], start, 0
        while frames < seconds * self.header["frame_rate"]:
            links = self.links_from(node)
            k, node = links[rng.integers(len(links))]
            walk.append((k, node))
            frames += self.n_frames[node[3]]
        return walk

    def times_to(self, goal_cells):
        """{node: frames} of the quickest way from every node to any of the cells [(x, y), ...]: Dijkstra, backwards."""
        goal = {self.cell(x, y) for x, y in goal_cells}
        nodes = map(tuple, self.all_nodes().tolist())
        times = {node: 0 for node in nodes if self.cell(node[0], node[1]) in goal}
        queue = [(0, node) for node in times]
        heapq.heapify(queue)
        while queue:
            frames, node = heapq.heappop(queue)
            if frames > times[node]:
                continue
            for _, (x, y, heading, segment) in self.links_to(node):
                start = (x % self.nx, y % self.ny, heading, segment) if self.tiled else (x, y, heading, segment)
                total = frames + self.n_frames[node[3]]
                if total < times.get(start, total + 1):
                    times[start] = total
                    heapq.heappush(queue, (total, start))
        return times

    def shortest_walk(self, start, times):
        """[(stencil, node), ...] after ``start``: the quickest way to the goal of :meth:`times_to`."""
        walk, node = [], start
        while self._time(times, node) > 0:
            left = self._time(times, node)
            node_of = ((k, end) for k, end in self.links_from(node))
            k, node = next(pair for pair in node_of if self._time(times, pair[1]) + self.n_frames[pair[1][3]] == left)
            walk.append((k, node))
        return walk

    def _time(self, times, node):
        x, y, heading, segment = node
        return times[(x % self.nx, y % self.ny, heading, segment) if self.tiled else node]

    def root_path(self, start, walk):
        """(n, 3) world x, y (m) and heading (rad, not wrapped) of the root on every frame of a walk from ``start``."""
        step = 2 * np.pi / self.n_headings
        frames = [np.array([[*self.position(start), start[2] * step]])]
        node = start
        for k, end in walk:
            part = slice(self.first[end[3]], self.first[end[3] + 1])
            angle, error = node[2] * step, self.share[part, None] * self.error[k]
            x, y, heading = self.path[part].T
            placed = np.column_stack([np.cos(angle) * x - np.sin(angle) * y, np.sin(angle) * x + np.cos(angle) * y])
            placed = np.column_stack([self.position(node) + placed + error[:, :2], heading + error[:, 2]])
            placed[:, 2] += frames[-1][-1, 2]
            frames.append(placed[1:])
            node = end
        return np.concatenate(frames)

    def position(self, node):
        """World x, y (m) of the centre of a node's cell."""
        return self.origin + (np.array(node[:2]) + 0.5) * self.cell_size

    def pose_times(self, node):
        """Animation of clips.glb, and the seconds in it between which a node's segment is played."""
        segment = self.segments[node[3]]
        return segment["clip"], segment["start"], segment["end"]


def read_file(path):
    """Bytes of a file; a device or a pipe, which has no end, is none."""
    if path.exists() and not path.is_file():
        raise Damaged(f"'{path}' is no file")
    return path.read_bytes()


def read_header(folder):
    header = json.loads(read_file(Path(folder) / "embedding.json").decode("utf-8"))
    if header.get("format") != "wayfarer engine embedding" or header["version"] > 1:
        raise Damaged(f"'{folder}' holds no embedding that this reader knows")
    return header


def read_arrays(raw):
    """Arrays of embedding.npz by name; none is made that a file of this size can hardly hold."""
    arrays, left = {}, max(64_000_000, 100 * len(raw))
    with zipfile.ZipFile(io.BytesIO(raw)) as archive:
        for name in ("nodes", "valid", "free", "follow", "stencil", "error", "path", "share", "first"):
            with archive.open(name + ".npy") as file:
                np.lib.format.read_magic(file)
                shape, by_columns, kind = np.lib.format.read_array_header_1_0(file)
                size = math.prod(shape) * kind.itemsize
                left -= size
                if left < 0 or kind.str not in ("|u1", "<i4", "<f8"):
                    raise Damaged(f"the array '{name}' is none that an export has")
                values = np.frombuffer(file.read(size), kind)
                arrays[name] = values.reshape(shape, order="F" if by_columns else "C")
    return arrays


def read_table(folder):
    """(n, 4) nodes, (n + 1,) where each one's links begin, and the nodes that these lead to, of embedding.table."""
    header = read_header(folder)
    if header.get("table") is None:
        raise Damaged(f"'{folder}' holds no table: it was left out; export again with it")
    raw, n = read_file(Path(folder) / Path(header["table"]["file"]).name), header["nodes"]
    if len(raw) < 12 * n + 4:
        raise Damaged(f"the table in '{folder}' is shorter than its header says")
    numbers = np.frombuffer(raw, "<u4", offset=8 * n)
    return np.frombuffer(raw, "<u2", 4 * n).reshape(n, 4), numbers[: n + 1], numbers[n + 1 :]


if __name__ == "__main__":
    if len(sys.argv) != 2:
        print("usage: python wayfarer_reader.py FOLDER", file=sys.stderr)
        sys.exit(2)
    try:
        embedding = Embedding(sys.argv[1])
    except (OSError, Damaged) as error:
        sys.exit(f"wayfarer_reader.py: {error}")
    except UNSOUND:
        sys.exit(f"wayfarer_reader.py: what '{sys.argv[1]}' holds is damaged")
    rng = np.random.default_rng(0)
    start = embedding.any_node(rng)
    walk = embedding.random_walk(start, 20.0, rng)
    print(f"{len(embedding.all_nodes()):,} nodes; a walk of 20 s from {start}:")
    for _, node in walk:
        print("  {} {:.2f}-{:.2f} s".format(*embedding.pose_times(node)), "to cell", node[:2])
