"""The zip that `dev.py build` makes: what is in it, the same bytes every time, and its whole life in clean Blenders.

The Blender that runs the tests is always tried; from .venv, those of `dev.py test --blender VERSION` as well, as far as
they are there. WAYFARER_BPY_PYTHONS names further Pythons that have bpy (separated as in PATH), WAYFARER_BLENDER_ROOT a
folder that holds a system with Blender in it (else /opt/blender-sid); without it that test is skipped.
"""

import json
import os
import re
import shutil
import subprocess
import sys
import tomllib
import uuid
import zipfile
from pathlib import Path

import pytest

import dev
from tests.window.blender_window import blender_root, why_not_here

HERE = Path(__file__).parent
SCRIPTS = ("install_extension.py", "registered.py")
# Prints the paths in site-packages of bpy and of what it requires; SciPy is not among it, because Blender has none.
WHAT_BPY_NEEDS = """
import importlib.metadata as metadata, re
names, paths = ["bpy"], {}
while names:
    name = names.pop()
    try:
        distribution = metadata.distribution(name)
    except metadata.PackageNotFoundError:
        continue
    if name not in paths:
        firsts = {file.parts[0] for file in distribution.files} - {"..", "__pycache__"}
        paths[name] = [str(distribution.locate_file(first)) for first in firsts]
        wanted = [wish for wish in distribution.requires or () if "extra ==" not in wish]
        names += [re.match(r"[\\w.-]+", wish).group() for wish in wanted]
print("\\n".join(path for several in paths.values() for path in several))
"""
OLDER = "0.0.1"
PAGES = ("LICENSE", "README.md", "CHANGELOG.md")
# In .venv-VERSION that Blender alone: each has its own run.
PYTHONS = [Path(sys.executable), *(dev.other_pythons() if Path(sys.prefix).name == ".venv" else [])]
PYTHONS += [Path(word) for word in os.environ.get("WAYFARER_BPY_PYTHONS", "").split(os.pathsep) if word]


@pytest.fixture(scope="module")
def wheels():
    """SciPy for this platform; the tests never fetch anything."""
    platform = dev.this_platform()
    missing = dev.missing_wheels(platform)
    if missing:
        pytest.skip(f"no SciPy for Python {', '.join(missing)} in the folder wheels; python3 dev.py build downloads it")
    return dev.download_wheels(platform, sys.executable)


@pytest.fixture(scope="module")
def archive(wheels, tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("built") / "wayfarer.zip"
    dev.build_archive(dev.this_platform(), wheels, path, sys.executable)  # by the Blender that runs the tests
    return path


@pytest.fixture(scope="module")
def older_archive(archive) -> Path:
    """The same with an older version number and a module that the newer one no longer has."""
    path = archive.with_name("older.zip")
    with zipfile.ZipFile(archive) as new, zipfile.ZipFile(path, "w") as older:
        for entry in new.infolist():
            content = new.read(entry)
            if entry.filename == "blender_manifest.toml":
                content = re.sub(rb'(?m)^version = ".*"', f'version = "{OLDER}"'.encode(), content)
            older.writestr(entry, content)
        older.writestr("addon/gone.py", "")
    return path


# ------------------------------------------------------------------------------------------------ content


def test_only_what_blender_needs_is_in_it(archive, wheels):
    with zipfile.ZipFile(archive) as built:
        names = set(built.namelist())
        manifest = tomllib.loads(built.read("blender_manifest.toml").decode())
        assert built.testzip() is None
    shipped = {path.relative_to(dev.ROOT) for part in ("addon", "core") for path in dev.ROOT.glob(f"{part}/**/*.py")}
    assets = {path.relative_to(dev.ROOT) for path in dev.ROOT.glob("assets/**/*") if path.is_file()}
    shipped |= {path for path in assets if "__pycache__" not in path.parts}
    shipped |= {path.relative_to(dev.ROOT) for path in dev.ROOT.glob("docs/*.md")}
    sources = {path.as_posix() for path in shipped}
    # Nothing of a developer's, whatever folders it may lie in.
    kinds = {Path(name).suffix for name in sources}
    assert kinds <= {".py", ".blend", ".bvh", ".json", ".npz", ".md", ".txt", ".svg", ".png", ".jpg", ".toml"}, kinds
    of_developers = ("tests", "tools/", "__pycache__", ".git", "dev.py", "pyproject")
    assert not any(word in name for name in names for word in of_developers)
    shipped_wheels = {f"wheels/{wheel.name}" for wheel in wheels}
    assert names == sources | shipped_wheels | {"__init__.py", "blender_manifest.toml", *PAGES}
    assert manifest["platforms"] == [dev.this_platform()]
    assert {wheel.removeprefix("./") for wheel in manifest["wheels"]} == shipped_wheels


def test_pages_lead_to_what_is_in_it(archive, tmp_path):
    with zipfile.ZipFile(archive) as built:
        built.extractall(tmp_path)
    pages = [tmp_path / "README.md", *tmp_path.glob("docs/*.md")]
    assert len(pages) > 3
    for page in pages:
        targets = [target.partition("#")[0] for target in re.findall(r"\]\(([^)\s]+)\)", page.read_text("utf-8"))]
        assert [name for name in targets if name and ":" not in name and not (page.parent / name).exists()] == []
    readme = (tmp_path / "README.md").read_text("utf-8")
    assert "(assets/pictures/view.jpg)" in readme and "(docs/guide.md)" in readme
    # What is only for developers is named, and leads nowhere.
    assert "How to contribute" in readme and "CONTRIBUTING.md" not in readme


def test_there_is_scipy_for_each_python_of_the_supported_blenders(wheels):
    pythons = [re.search(r"-cp3(\d+)-", wheel.name).group(1) for wheel in wheels]
    assert {"11", "13"} <= set(pythons) and len(set(pythons)) == len(pythons)


def test_the_same_source_makes_the_same_bytes(archive, wheels, tmp_path, monkeypatch):
    # As from a checkout made at another time, on another system, where files lie in another order.
    copy = tmp_path / "elsewhere"
    for name in reversed(dev.SHIPPED):
        source = dev.ROOT / name
        if source.is_dir():
            shutil.copytree(source, copy / name, copy_function=shutil.copyfile)
        else:
            copy.mkdir(exist_ok=True)
            shutil.copyfile(source, copy / name)
    for path in copy.rglob("*"):
        os.utime(path, (1.7e9, 1.7e9))
        path.chmod(0o755)
    monkeypatch.setattr(dev, "ROOT", copy)
    again = tmp_path / "again.zip"
    dev.build_archive(dev.this_platform(), wheels, again, sys.executable)
    assert again.read_bytes() == archive.read_bytes()
    with zipfile.ZipFile(again) as built:
        assert built.namelist() == sorted(built.namelist())


# --------------------------------------------------------------------------------------------- whole lives


def assert_lived_well(result: subprocess.CompletedProcess) -> dict:
    assert result.returncode == 0, result.stdout + result.stderr
    assert "Traceback" not in result.stdout + result.stderr, result.stdout + result.stderr
    found = json.loads(next(line for line in reversed(result.stdout.splitlines()) if line.startswith("{")))
    version = re.search(r'^version = "(.+)"', dev.MANIFEST.read_text("utf-8"), re.MULTILINE).group(1)
    assert (found["older"], found["upgraded"]) == (OLDER, version)
    assert not found["scipy_before"] and found["scipy"][1].startswith(found["resources"])
    assert all(value > 0 for value in found["numbers"].values())
    assert found["numbers_read_back"] == found["numbers"]
    for what in ("left_when_disabled", "missing_when_enabled_again", "left_registered", "left_files", "left_modules"):
        assert found[what] == [], what
    assert not found["left_in_preferences"] and found["actions_without_it"] > 0
    return found


def clean_site(python: Path, folder: Path) -> Path:
    """A folder with the bpy of a Python and what it needs, but no SciPy."""
    result = subprocess.run([python, "-c", WHAT_BPY_NEEDS], capture_output=True, text=True)
    assert result.returncode == 0, result.stderr
    paths = [Path(line) for line in result.stdout.split("\n") if line]
    if "bpy" not in {path.name for path in paths}:
        pytest.skip(f"{python} has no bpy")
    assert "scipy" not in {path.name for path in paths}
    folder.mkdir()
    for path in paths:
        (folder / path.name).symlink_to(path)
    return folder


@pytest.mark.parametrize("python", PYTHONS, ids=lambda python: python.parent.parent.name)
def test_from_installing_to_uninstalling(python, archive, older_archive, tmp_path):
    site = clean_site(python, tmp_path / "site")
    work = tmp_path / "Künstler und Söhne"
    work.mkdir()
    names = {key: value for key, value in os.environ.items() if not key.startswith("PYTHON")}
    result = subprocess.run(
        # Without the packages of the Python's own: Blender's Python has but a few.
        [python, "-S", str(HERE / SCRIPTS[0]), str(archive), str(older_archive), str(work)],
        env={**names, "BLENDER_USER_RESOURCES": str(work / "user"), "PYTHONPATH": str(site)},
        capture_output=True,
        text=True,
        timeout=900,
    )
    assert_lived_well(result)


def test_in_blender_itself(archive, older_archive):
    root = blender_root()
    if why_not_here(root):
        pytest.skip(why_not_here(root))
    inside = Path("/tmp") / f"wayfarer-{uuid.uuid4().hex}"
    job = root / inside.relative_to("/")
    job.mkdir()
    try:
        for file in (archive, older_archive, *(HERE / name for name in SCRIPTS)):
            shutil.copy(file, job)
        words = [str(inside / name) for name in (archive.name, older_archive.name)]
        result = subprocess.run(
            ["chroot", root, "env", f"BLENDER_USER_RESOURCES={inside}/user", "HOME=/tmp", "blender", "--quiet"]
            + ["--factory-startup", "--background", "--python", f"{inside}/{SCRIPTS[0]}", "--", *words, str(inside)],
            capture_output=True,
            text=True,
            timeout=900,
        )
    finally:
        shutil.rmtree(job)
    assert_lived_well(result)
