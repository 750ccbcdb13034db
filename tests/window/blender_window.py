"""Runs a script in a Blender with a window, on a virtual screen of its own.

Blender lies in a folder that holds a whole system, with Xvfb and ImageMagick in it: WAYFARER_BLENDER_ROOT names the
folder. Nobody needs to look: the script moves the mouse and presses keys itself, and takes pictures of the screen.
"""

import contextlib
import os
import shutil
import subprocess
import uuid
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

DEFAULT_ROOT = Path("/opt/blender-sid")
SCREEN = (1600, 1000)


@dataclass(frozen=True)
class Outcome:
    """What a script left: Blender's exit code (None if it had to be stopped) and everything that it printed."""

    code: int | None
    log: str


def blender_root() -> Path:
    """The folder that holds a system with Blender in it, whether it is there or not."""
    return Path(os.environ.get("WAYFARER_BLENDER_ROOT") or DEFAULT_ROOT)


def why_not_here(root: Path) -> str:
    """What is missing to open Blender's window, as a reason to skip tests; empty if nothing is."""
    if not (root / "usr" / "bin" / "blender").exists():
        return f"no Blender in {root}: set WAYFARER_BLENDER_ROOT to a folder that holds a system with Blender in it"
    # Links in there lead to places that are elsewhere when seen from here.
    missing = [name for name in ("Xvfb", "import") if not os.path.lexists(root / "usr" / "bin" / name)]
    if missing:
        return f"the system in {root} lacks {' and '.join(missing)}"
    return "" if os.geteuid() == 0 else "only root may change into another system"


@contextlib.contextmanager
def job_folder(root: Path) -> Iterator[Path]:
    """A folder inside the other system, removed at the end."""
    folder = root / "tmp" / f"wayfarer-{uuid.uuid4().hex}"
    folder.mkdir()
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def run_in_window(root: Path, job: Path, script: str, seconds: float) -> Outcome:
    """Run a script of the job folder in a Blender with factory settings; it has to end Blender itself.

    The script finds its own folder, as the other system calls it, in WAYFARER_JOB.
    """
    inside = "/" + job.relative_to(root).as_posix()
    with _virtual_screen(root) as display:
        names = {
            "BLENDER_USER_RESOURCES": f"{inside}/user",
            "WAYFARER_JOB": inside,
            "DISPLAY": display,
            "HOME": inside,
            "TMPDIR": inside,
            "XDG_RUNTIME_DIR": inside,
            # The same pictures on every machine.
            "LIBGL_ALWAYS_SOFTWARE": "1",
        }
        command = ["chroot", str(root), "env", *(f"{name}={value}" for name, value in names.items())]
        command += ["blender", "--enable-event-simulate", "--gpu-backend", "opengl", "--factory-startup"]
        command += ["--window-geometry", "0", "0", *(str(pixels) for pixels in SCREEN)]
        command += ["--python", f"{inside}/{script}"]
        log = job / "blender.log"
        with log.open("wb") as output:
            blender = subprocess.Popen(command, stdout=output, stderr=subprocess.STDOUT)
            try:
                code = blender.wait(timeout=seconds)
            except subprocess.TimeoutExpired:
                code = None
            finally:
                _end(blender)
    return Outcome(code, log.read_text("utf-8", errors="replace"))


@contextlib.contextmanager
def _virtual_screen(root: Path) -> Iterator[str]:
    """A screen that nobody sees; yields its name, which the server chooses."""
    read, write = os.pipe()
    size = f"{SCREEN[0]}x{SCREEN[1]}x24"
    command = ["chroot", str(root), "Xvfb", "-displayfd", str(write), "-screen", "0", size, "-nolisten", "tcp"]
    server = subprocess.Popen(command, pass_fds=[write], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    os.close(write)
    try:
        with os.fdopen(read) as answer:
            number = answer.readline().strip()
        if not number:
            raise RuntimeError("Xvfb did not start")
        yield f":{number}"
    finally:
        _end(server)


def _end(process: subprocess.Popen) -> None:
    """chroot replaces itself by the program: what is ended is the program."""
    if process.poll() is None:
        process.terminate()
        try:
            process.wait(timeout=5)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
