"""Mixins of operators: what they need before they can run, a folder to choose, a click on the floor."""

import functools

import bpy
from bpy_extras import view3d_utils

from ...core.errors import MotionGraphError
from ..bridge.clip_actions import character_problem
from ..jobs import LongOperator
from ..results.advice import stale_advice
from ..results.store import embedding_of, results


class Needs:
    """Mixin: an operator that cannot run without something."""

    @classmethod
    def problem(cls, context) -> str:
        """Return what the operator lacks, as a sentence without a full stop; nothing if it can run."""
        raise NotImplementedError

    @classmethod
    def poll(cls, context):
        problem = cls.problem(context)
        if problem:
            cls.poll_message_set(problem)
        return not problem


class NeedsObjectMode(Needs):
    """Mixin: object mode."""

    @classmethod
    def problem(cls, context):
        return "" if context.mode == "OBJECT" else "Switch to Object Mode first"


class NeedsCharacter(Needs):
    """Mixin: a character."""

    @classmethod
    def problem(cls, context):
        return "" if context.scene.wayfarer.character else "Choose a character first"


class NeedsRig(Needs):
    """Mixin: a character that is an armature of the scene."""

    @classmethod
    def problem(cls, context):
        return character_problem(context.scene)


class NeedsClips(NeedsRig):
    """Mixin: a character, and at least one of its clips ticked."""

    @classmethod
    def problem(cls, context):
        if any(clip.use for clip in context.scene.wayfarer.clips):
            return super().problem(context)
        return super().problem(context) or "Give the character actions, refresh the clips and tick at least one"


class LooksAtEmbedding(Needs):
    """Mixin: an embedding, be it an empty one."""

    @classmethod
    def problem(cls, context):
        return "Embed the motion graph first" if results(context.scene).embedding is None else ""

    def warn_if_stale(self, scene) -> None:
        """Report what has changed since the embedding was made; last, so that it stays to be read."""
        for sentence in stale_advice(scene):
            self.report({"WARNING"}, sentence)


class AsksEmbedding(LooksAtEmbedding):
    """Mixin: an embedding in which the character can go somewhere."""

    @classmethod
    def problem(cls, context):
        problem = super().problem(context)
        if problem or embedding_of(context.scene).n_nodes:
            return problem
        return "The character cannot go anywhere in this scene; the embedding is empty"


class NeedsEmbedding(AsksEmbedding):
    """Mixin: a character, and an embedding in which it can go somewhere."""

    @classmethod
    def problem(cls, context):
        return character_problem(context.scene) or super().problem(context)


def reports_errors(execute):
    """Decorate an operator's ``execute``: a MotionGraphError becomes a report, and nothing else has to be returned."""

    @functools.wraps(execute)
    def wrapped(self, context):
        try:
            return execute(self, context) or {"FINISHED"}
        except MotionGraphError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}

    return wrapped


class Browses(LongOperator):
    """Mixin: long work on the folder ``directory``, which a file browser asks for unless it is given."""

    _browsing = False

    def invoke(self, context, event):
        if self.directory:
            return super().invoke(context, event)
        self._browsing = True
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        if not self._browsing:
            return super().execute(context)
        # The file browser would stand still until all was done: the work is a step of undo of its own.
        options = self.as_keywords(ignore=("files",))
        if hasattr(self, "files"):
            options["files"] = [{"name": file.name} for file in self.files]
        operator = getattr(bpy.ops.wayfarer, type(self).__name__.removeprefix("WAYFARER_OT_"))
        operator("INVOKE_DEFAULT", True, **options)
        return {"CANCELLED"}


class PicksOnFloor:
    """Mixin: a modal operator in a 3D viewport, until Esc or a right click; ``execute`` is what it does without one."""

    picking_cursor = "CROSSHAIR"

    def invoke(self, context, event):
        if bpy.app.background or context.window is None:
            return self.execute(context)
        if context.area is None or context.area.type != "VIEW_3D":
            self.report({"ERROR"}, "Start this in a 3D viewport")
            return {"CANCELLED"}
        self._picking = True
        self.begin(context)
        context.window.cursor_modal_set(self.picking_cursor)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        try:
            # Another editor may have taken the viewport's place.
            lost = context.area is None or context.area.type != "VIEW_3D"
            if lost or (event.type in {"ESC", "RIGHTMOUSE"} and event.value == "PRESS"):
                self.stop(context)
                return {"CANCELLED"}
            return self.handle(context, event)
        except BaseException:
            # Not handled here, but cursor, timers and drawing must not outlive the operator.
            self.stop(context)
            raise

    def cancel(self, context):
        """Called by Blender when it ends the operator itself, for example on opening another file."""
        self.stop(context)

    def begin(self, context) -> None:
        """Picking begins."""

    def handle(self, context, event) -> set[str]:
        """Something has happened, other than the end."""
        raise NotImplementedError

    def end(self, context) -> None:
        """Picking has ended."""

    def stop(self, context) -> None:
        if not self._picking:
            return
        self._picking = False
        context.window.cursor_modal_restore()
        context.workspace.status_text_set(None)
        self.end(context)


def clicked(event) -> bool:
    return event.type == "LEFTMOUSE" and event.value == "PRESS"


def ground_under(region, view, mouse, height: float) -> tuple[float, float] | None:
    """World x, y (m) of the ground, at ``height`` (m), under the mouse (pixels in the region); None in the sky."""
    origin = view3d_utils.region_2d_to_origin_3d(region, view, mouse)
    direction = view3d_utils.region_2d_to_vector_3d(region, view, mouse)
    if abs(direction.z) < 1e-9:
        return None
    distance = (height - origin.z) / direction.z
    if distance < 0 and view.is_perspective:
        return None
    place = origin + distance * direction
    return place.x, place.y


def viewport_under(context, event):
    """The viewport's main region under the mouse; None over its sidebar and toolbars, and elsewhere."""
    for kind in ("UI", "TOOLS", "HEADER", "TOOL_HEADER", "WINDOW"):
        for region in context.area.regions:
            if region.type == kind and region.width > 1:
                x, y = event.mouse_x - region.x, event.mouse_y - region.y
                if 0 <= x < region.width and 0 <= y < region.height:
                    return region if kind == "WINDOW" else None
    return None
