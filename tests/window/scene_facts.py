"""What there is in the scene and what was computed for it, in a form that can be compared and written down."""

import hashlib
import importlib
import os
from collections.abc import Generator
from pathlib import Path

import bpy
import hand
import numpy as np
import picture

#: Where pictures and the saved file go.
JOB = Path(__file__).parent


def part(name: str):
    """A module of the extension, by its name in the folder addon."""
    return importlib.import_module(f"{hand.EXTENSION}.addon.{name}")


def results():
    return part("results.store").results(bpy.context.scene)


def settings():
    return bpy.context.scene.wayfarer


def keep_picture(name: str) -> None:
    picture.save_picture(str(JOB / f"{name}.png"))


def colors() -> str:
    """What is painted on the floor, as a fingerprint; empty without a floor."""
    floor = part("render.floor").find_floor(bpy.context.scene)
    if floor is None:
        return ""
    attribute = floor.data.attributes.active_color
    values = np.empty(4 * len(attribute.data), np.float32)
    attribute.data.foreach_get("color", values)
    return hashlib.sha256(values.tobytes()).hexdigest()


def everything() -> str:
    """What is in the scene and what was computed for it, as a fingerprint: the same if nothing was changed."""
    scene, found = bpy.context.scene, results()
    described = [
        sorted((obj.name, [round(v, 6) for row in obj.matrix_world for v in row]) for obj in scene.objects),
        sorted((action.name, tuple(action.frame_range)) for action in bpy.data.actions),
        sorted((mesh.name, len(mesh.vertices)) for mesh in bpy.data.meshes),
        sorted(collection.name for collection in bpy.data.collections),
        scene.frame_current,
        colors(),
        repr(plain(scene.wayfarer)),
        [id(found.graph), id(found.embedding), id(found.painted), id(found.walk)],
        str(found.summary),
    ]
    return hashlib.sha256(repr(described).encode()).hexdigest()


def plain(group) -> dict:
    """The settings of a property group, and of those inside it, as plain values."""
    values = {}
    for name in group.bl_rna.properties.keys():  # noqa: SIM118  (no mapping)
        if name in ("rna_type", "name"):
            continue
        value = getattr(group, name)
        if isinstance(value, bpy.types.PropertyGroup):
            values[name] = plain(value)
        elif isinstance(value, bpy.types.bpy_prop_collection):
            values[name] = [plain(item) for item in value]
        else:
            values[name] = str(value[:]) if isinstance(value, bpy.types.bpy_prop_array) else repr(value)
    return values


def badges() -> dict[str, bool]:
    """What the panels call out of date."""
    staleness, scene = part("results.staleness"), bpy.context.scene
    kinds = ("graph", "embedding", "map", "walk")
    return {kind: getattr(staleness, f"{kind}_is_stale")(scene) for kind in kinds}


def numbers() -> dict:
    found = results()
    return {
        "segments": len(found.graph.segments) if found.graph else 0,
        "nodes": found.embedding.n_nodes if found.embedding else 0,
        "links": found.embedding.n_links if found.embedding else 0,
        "walk": len(found.walk) if part("results.shown").find_walk(bpy.context.scene) else 0,
        "painted": part("results.shown").find_painted(bpy.context.scene) is not None,
    }


def findings() -> dict[str, dict[str, str]]:
    """What was found out, by its kind: the numbers that the panels show."""
    numbers_of = part("results.findings").numbers_of
    return {kept.name: dict(numbers_of(kept)) for kept in settings().findings}


def settled() -> hand.Turns:
    """Until the map has followed what was changed."""
    live = part("live.live").evaluation(bpy.context.scene)
    yield from hand.until(lambda: live.painted, "the map to follow")
    yield from hand.redrawn()
    if live.error:
        raise hand.Waited(live.error)


def legend_facts() -> Generator[None, None, dict]:
    """Where the legend is, told by what disappears when it is switched off, and whether its colours are in it."""
    view, side = hand.region(), hand.region("UI")
    with_it = yield from _still(view)
    settings().overlay.show_legend = False
    without = yield from _still(view)
    settings().overlay.show_legend = True
    again = yield from _still(view)
    x, y, width, height = picture.changed_box(with_it, without) or (0, 0, 0, 0)
    legend = part("render.floor").floor_legend(part("render.floor").find_floor(bpy.context.scene))
    shown = with_it[y : y + height, x : x + width]
    wanted = [*legend.bar.stops, *(swatch.color for swatch in legend.swatches)]
    return {
        "size": [width, height],
        "swatches": len(legend.swatches),
        "inside": view.x + x + width <= side.x and width > 0,
        "farthest_color": max(picture.nearest_distance(shown, color) for color in wanted),
        "back": bool((again[y : y + height, x : x + width] == shown).all()),
    }


def _still(view) -> Generator[None, None, np.ndarray]:
    """The pixels of a region, once it shows the same twice: a report that fades does not count as a change."""
    yield from hand.redrawn()
    seen = None
    for _ in range(100):
        now = picture.pixels()[view.y : view.y + view.height, view.x : view.x + view.width]
        if seen is not None and (now == seen).all():
            return now
        seen = now
        yield
    raise RuntimeError("the viewport does not come to rest")


_BROWSER = """#!/bin/sh
echo "$1" >> {opened}
"""


def log_browser() -> Path:
    """The file in which a stand-in for the browser writes down the pages that are opened; there is none yet."""
    opened, browser = JOB / "opened.txt", JOB / "browser"
    browser.write_text(_BROWSER.format(opened=opened), "utf-8")
    browser.chmod(0o700)
    # Python's own way to name a browser; it looks once.
    os.environ["BROWSER"] = f"{browser} %s"
    opened.unlink(missing_ok=True)
    return opened
