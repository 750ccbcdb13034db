"""The first half of the session: from an empty scene to a painted floor."""

import bpy
import hand
import picture
import sidebar
from mathutils import Vector
from scene_facts import JOB, badges, colors, everything, keep_picture, legend_facts, numbers, results, settings


def install(note) -> hand.Turns:
    """Install the extension from its zip, as Preferences > Get Extensions > Install from Disk does."""
    archive = str(JOB / "wayfarer.zip")
    done = bpy.ops.extensions.package_install_files(filepath=archive, repo="user_default", enable_on_install=True)
    note("done", list(done))
    hand.count_redraws()
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)
    bpy.context.scene.render.fps = 30
    bpy.ops.ed.undo_push(message="Empty Scene")
    view3d = hand.viewport().spaces.active.region_3d
    view3d.view_location, view3d.view_distance = (1.15, 0.5, 0.0), 12.8
    view3d.view_rotation = Vector((0.35, -0.75, 0.95)).to_track_quat("Z", "Y")
    yield


def look_around(note) -> hand.Turns:
    """The sidebar before anything was done: every panel says what comes first."""
    yield from sidebar.open_sidebar()
    keep_picture("01_empty")
    yield from sidebar.scroll(12)
    keep_picture("01_empty_below")
    yield from sidebar.scroll(-15)
    yield from sidebar.close_panels()
    note("panels", sidebar.panels())
    note("disabled", [name for name in dir(bpy.ops.wayfarer) if not getattr(bpy.ops.wayfarer, name).poll()])


def add_character(note) -> hand.Turns:
    yield from sidebar.press_button("Clips", "wayfarer.add_sample_character")
    yield from hand.until(lambda: settings().character is not None, "the character")
    yield from hand.work_is_done()
    note("clips", len(settings().clips))
    keep_picture("02_clips")


def add_room(note) -> hand.Turns:
    yield from sidebar.open_panel("Environment")
    # The button above this one opens a menu.
    x, y = yield from sidebar.find_button("wayfarer.environment.ground_source")
    yield from hand.click(x, y + 26)
    yield from hand.redrawn()
    keep_picture("03_menu_of_scenes")
    yield from hand.press("DOWN_ARROW")
    yield from hand.press("RET")
    yield from hand.until(lambda: settings().environment.ground is not None, "the room")
    yield from hand.redrawn()
    note("ground", settings().environment.ground.name)
    note("regions", len(settings().environment.regions))
    note("collections", sorted(c.name for c in bpy.data.collections if c.name.startswith("Wayfarer")))
    keep_picture("04_environment")


def show_environment(note) -> hand.Turns:
    """The environment is in the viewport while its box is ticked, whatever the sidebar shows."""
    view = hand.region()
    # Where neither the sidebar nor what makes room for it is, and above the last operator's settings.
    rows = slice(view.y + view.height // 6, view.y + view.height)
    columns = slice(view.x, view.x + view.width // 2)

    def viewport():
        return picture.pixels()[rows, columns]

    def look(name: str) -> hand.Turns:
        """Which picture the viewport shows after something was done, and how often it was drawn until it rests."""
        yield from hand.rest()
        # Long enough for what would go on for ever.
        seen, turns = hand.n_drawn(), 0
        while turns < 15:
            turns += 1
            yield
        drawn_at_rest = hand.n_drawn() - seen
        now = viewport()
        note(name, [picture.n_changed(plain, now), picture.n_changed(lines, now), drawn_at_rest])

    box = "Environment", "wayfarer.overlay.show_environment"
    yield from sidebar.open_panel("Environment")
    yield from hand.rest()
    plain = viewport()
    yield from sidebar.press_button(*box)
    yield from hand.until(lambda: picture.n_changed(plain, viewport()) > 500, "the lines of the environment")
    yield from hand.rest()
    lines = viewport()
    note("lines", picture.n_changed(plain, lines))
    yield from look("ticked")
    yield from sidebar.close_panel("Environment")
    yield from look("panel_closed")
    yield from sidebar.turn_tabs(-1)
    note("tab", hand.region("UI").active_panel_category)
    yield from look("other_tab")
    keep_picture("04_other_tab")
    yield from sidebar.turn_tabs(1)
    yield from _toggle_sidebar(shown=False)
    yield from look("sidebar_hidden")
    keep_picture("04_sidebar_hidden")
    yield from _toggle_sidebar(shown=True)
    yield from sidebar.open_panel("Environment")
    yield from sidebar.press_button(*box)
    yield from look("unticked")


def _toggle_sidebar(*, shown: bool) -> hand.Turns:
    """Show or hide the sidebar by its key, and wait for it to have slid."""
    yield from hand.press_in_viewport("N")
    yield from hand.until(lambda: (hand.region("UI").width > 1) == shown, "the sidebar to slide")
    yield from hand.until(lambda: hand.viewport().spaces.active.show_region_ui == shown, "the sidebar to have slid")


def cancel_building(note) -> hand.Turns:
    yield from _cancel(note, "Motion Graph", "wayfarer.build_motion_graph", "05_building")


def build(note) -> hand.Turns:
    yield from sidebar.press_button("Motion Graph", "wayfarer.build_motion_graph")
    yield from hand.until(lambda: results().graph is not None, "the motion graph")
    yield from hand.work_is_done()
    note("segments", numbers()["segments"])
    keep_picture("06_motion_graph")


def embed(note) -> hand.Turns:
    yield from sidebar.press_button("Embedding", "wayfarer.embed")
    yield from hand.until(lambda: results().embedding is not None, "the embedding")
    yield from hand.work_is_done()
    note("nodes", numbers()["nodes"])
    note("stale", badges())
    keep_picture("07_embedding")


def cancel_embedding(note) -> hand.Turns:
    """On a finer grid, so that there is a middle to press Esc in; the result that is there must stay."""
    environment = settings().environment
    before, environment.cell_size = environment.cell_size, 0.06
    yield from hand.redrawn()
    yield from _cancel(note, "Embedding", "wayfarer.embed", "08_embedding_runs")
    environment.cell_size = before
    yield from hand.redrawn()
    note("stale", badges())


def _cancel(note, panel: str, operator: str, name: str) -> hand.Turns:
    """Press a button, and Esc in the middle of its work."""
    before, turns = everything(), 0
    identifier = operator.replace("wayfarer.", "WAYFARER_OT_")
    yield from sidebar.press_button(panel, operator)
    yield from hand.until(lambda: identifier in hand.running(), f"{operator} to begin")
    for _ in range(4):
        yield
        turns += identifier in hand.running()
    keep_picture(name)
    note("ran", turns)
    yield from hand.press("ESC")
    yield from hand.until(lambda: not hand.running(), f"{operator} to end")
    yield from hand.redrawn()
    note("same", everything() == before)


def paint(note) -> hand.Turns:
    yield from sidebar.press_button("Map", "wayfarer.paint_map")
    yield from hand.until(colors, "the painted floor")
    yield from hand.work_is_done()
    note("stale", badges())
    keep_picture("09_map")


def look_at_legend(note) -> hand.Turns:
    for name, value in (yield from legend_facts()).items():
        note(name, value)


def undo_map(note) -> hand.Turns:
    painted = colors()
    yield from hand.press_in_viewport("Z", ctrl=True)
    yield from hand.until(lambda: not colors(), "the floor to be gone")
    yield from hand.redrawn()
    note("gone", not numbers()["painted"])
    yield from hand.press_in_viewport("Z", ctrl=True, shift=True)
    yield from hand.until(colors, "the floor to be back")
    yield from hand.redrawn()
    note("same", colors() == painted and numbers()["painted"])
    note("stale", badges())
