"""Build the Blender extension: one zip a platform, with the wheels that it bundles.

    python scripts/build/build_extension.py                 # for this machine, into dist/
    python scripts/build/build_extension.py --all           # linux-x64, windows-x64, macos-arm64
    python scripts/build/build_extension.py --all --update  # the pins have changed: rewrite the manifest's list
    python scripts/build/build_extension.py --python 3.14 --output build   # for a Blender with another Python

Run it with a Python that has bpy: building and validating are done by the tool that Blender brings
along (`blender_ext.py`), on a copy of the sources below build/extension/, since its manifest may only
list wheels that are there.
"""

from __future__ import annotations

import argparse
import importlib.util
import os
import platform
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
MANIFEST = ROOT / "blender_manifest.toml"
WHEELS = ROOT / "wheels"
STAGE = ROOT / "build" / "extension"

PYTHONS = ("3.11", "3.13")  # Blender 4.5 and 5.0; 5.1 and 5.2
PLATFORMS = {  # Blender's name: pip's names
    "linux-x64": ("manylinux_2_28_x86_64", "manylinux_2_27_x86_64", "manylinux2014_x86_64"),
    "windows-x64": ("win_amd64",),
    "macos-arm64": ("macosx_12_0_arm64",),
}
FILES = {  # …, and what the names of its wheels end with
    "linux-x64": r"-(any|manylinux\w*_x86_64(\.manylinux\w*)*)\.whl",
    "windows-x64": r"-(any|win_amd64)\.whl",
    "macos-arm64": r"-(any|macosx_\d+_\d+_arm64)\.whl",
}
NOT_STAGED = shutil.ignore_patterns(".*", "__pycache__", "build", "dist", "wheels")


class BuildError(Exception):
    """The extension cannot be built; the message says why."""


def this_platform() -> str:
    """Blender's name of the platform this runs on."""
    name = f"{platform.system()}-{platform.machine()}".lower()
    for theirs, blenders in {"darwin": "macos", "x86_64": "x64", "amd64": "x64", "aarch64": "arm64"}.items():
        name = name.replace(theirs, blenders)
    if name not in PLATFORMS:
        raise BuildError(f"no extension is built for {name}; one of {', '.join(PLATFORMS)}")
    return name


def pinned_wheels() -> list[str]:
    """The requirements of the wheels, `name==version` each."""
    groups = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["dependency-groups"]
    return groups["wheels"]


def listed_wheels(name: str) -> set[str]:
    """File names of the wheels that the manifest lists for a platform."""
    wheels = tomllib.loads(MANIFEST.read_text(encoding="utf-8"))["wheels"]
    return {Path(wheel).name for wheel in wheels if re.search(FILES[name] + "$", wheel)}


def fetch(name: str, pythons: tuple[str, ...] = PYTHONS, folder: Path | None = None) -> set[str]:
    """Download the wheels of a platform, for every Python, and return their file names."""
    folder = folder or WHEELS / name
    folder.mkdir(parents=True, exist_ok=True)
    for python in pythons:
        command = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--only-binary=:all:"]
        command += [f"--platform={tag}" for tag in PLATFORMS[name]]
        command += [f"--python-version={python}", "--implementation=cp", f"--dest={folder}"]
        run([*command, *pinned_wheels()])
    return {path.name for path in folder.glob("*.whl")}


def ensure_wheels(name: str) -> None:
    """Bring wheels/<platform>/ to exactly the wheels that the manifest lists."""
    folder, listed = WHEELS / name, listed_wheels(name)
    for path in folder.glob("*.whl"):
        if path.name not in listed:
            path.unlink()
    if listed and {path.name for path in folder.glob("*.whl")} == listed:
        return
    fetched = fetch(name)
    if fetched != listed:
        raise BuildError(
            f"the pins in pyproject.toml fetch other wheels for {name} than {MANIFEST.name} lists "
            f"({', '.join(sorted(fetched ^ listed))}); bring the list up to date with --all --update"
        )


def wheels_for(name: str, python: str) -> Path:
    """A folder with the wheels of a platform for one Python, in the manifest or not (Linux distributions build Blender
    with newer ones). Downloads them again when the pins have changed."""
    folder = WHEELS / f"{name}-py{python}"
    stamp, pins = folder / "pins", "\n".join(pinned_wheels())
    if not stamp.exists() or stamp.read_text(encoding="utf-8") != pins:
        shutil.rmtree(folder, ignore_errors=True)
        fetch(name, (python,), folder)
        stamp.write_text(pins, encoding="utf-8")
    return folder


def update_manifest() -> None:
    """Write the list of wheels, of all platforms, into the manifest."""
    shutil.rmtree(WHEELS, ignore_errors=True)
    names = sorted(set().union(*(fetch(name) for name in PLATFORMS)))
    lines = "".join(f'  "./wheels/{wheel}",\n' for wheel in names)
    text = MANIFEST.read_text(encoding="utf-8")
    MANIFEST.write_text(replace_list(text, "wheels", lines), encoding="utf-8")


def replace_list(text: str, key: str, lines: str) -> str:
    """A TOML text with the top-level list `key` replaced."""
    result, count = re.subn(rf"^{key} = \[\n.*?^\]", f"{key} = [\n{lines}]", text, flags=re.M | re.S)
    if count != 1:
        raise BuildError(f"{MANIFEST.name} should have one list called {key}, not {count}")
    return result


def stage(name: str, source: Path, wheels: list[str]) -> Path:
    """A copy of the sources with the wheels of a folder and the manifest of one platform."""
    folder = STAGE / source.name
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(ROOT, folder, ignore=NOT_STAGED)
    (folder / "wheels").mkdir()
    for wheel in wheels:
        os.link(source / wheel, folder / "wheels" / wheel)
    text = (folder / MANIFEST.name).read_text(encoding="utf-8")
    text = replace_list(text, "wheels", "".join(f'  "./wheels/{wheel}",\n' for wheel in wheels))
    text = re.sub(r"^platforms = .*$", f'platforms = ["{name}"]', text, flags=re.M)
    (folder / MANIFEST.name).write_text(text, encoding="utf-8")
    from help_pages import write_pages  # needs the solver, for the pages of its public names

    write_pages(ROOT / "docs", folder / "help")
    return folder


def blender_tool() -> tuple[Path, Path]:
    """Blender's tool for extensions, and its list of the tags that exist."""
    spec = importlib.util.find_spec("bpy")
    if spec is None or spec.origin is None:
        raise BuildError(f"{sys.executable} has no bpy, which brings the tool that builds extensions")
    scripts = next(Path(spec.origin).parent.glob("*/scripts"))
    return (
        scripts / "addons_core/bl_pkg/cli/blender_ext.py",
        scripts / "modules/_bpy_internal/extensions/tags.py",
    )


def build(name: str, output: Path, python: str | None = None) -> Path:
    """Build and validate the zip of a platform, of one Python if it is given, and return its path."""
    if python is None:
        ensure_wheels(name)
        staged = stage(name, WHEELS / name, sorted(listed_wheels(name)))
    else:
        source = wheels_for(name, python)
        staged = stage(name, source, sorted(path.name for path in source.glob("*.whl")))
    tool, tags = blender_tool()
    output.mkdir(parents=True, exist_ok=True)
    arguments = [f"--source-dir={staged}", f"--output-dir={output}", f"--valid-tags={tags}"]
    run([sys.executable, str(tool), "build", "--split-platforms", *arguments])
    manifest = tomllib.loads(MANIFEST.read_text(encoding="utf-8"))
    built = output / f"{manifest['id']}-{manifest['version']}-{name.replace('-', '_')}.zip"
    run([sys.executable, str(tool), "validate", f"--valid-tags={tags}", str(built)])
    return built


def run(command: list[str]) -> None:
    """Run a command; its output is shown when it fails."""
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode:
        raise BuildError(f"{' '.join(command)}\nfailed:\n{done.stdout}")


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--all", action="store_true", help="every platform, not only this machine's")
    parser.add_argument("--update", action="store_true", help="rewrite the manifest's list of wheels")
    parser.add_argument("--python", help="wheels for this Python alone, for example 3.14; not for release")
    parser.add_argument("--output", type=Path, default=ROOT / "dist", help="folder for the zips (dist/)")
    options = parser.parse_args(arguments)
    try:
        if options.update:
            update_manifest()
        for name in PLATFORMS if options.all else (this_platform(),):
            built = build(name, options.output.resolve(), options.python)
            print(f"{built}: {built.stat().st_size / 1e6:.1f} MB")
    except BuildError as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
