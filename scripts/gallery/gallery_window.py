"""The pictures of the window in docs/: crops of those the window's tests took, build/gui/ → docs/images/window/.

    python -m scripts.gallery.gallery_window           # tells the stories first, where a window is possible
    python -m scripts.gallery.gallery_window --taken   # uses the pictures at hand

Files are called STORY-NUMBER-NAME.png; here pictures go by story and name, since a new step changes the numbers. On a
machine that can open no window a message says so, and the pictures stay as they are.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from pathlib import Path

import bpy
import numpy as np

ROOT = Path(__file__).resolve().parents[2]
TAKEN = ROOT / "build" / "gui"
IMAGES = ROOT / "docs" / "images" / "window"
RUN = ROOT / "tests" / "gui" / "run.sh"
IMPOSSIBLE = 2  # exit code of run.sh
LARGEST = 120_000  # bytes of a picture

# Left, top, width, height in a window of 1280 × 900.
WINDOW = (0, 0, 1280, 900)
VIEW = (60, 82, 925, 760)
WIDE = (250, 82, 1030, 790)
BESIDE = (420, 82, 860, 790)  # the sidebar and the viewport beside it
SIDEBAR = (988, 82, 292, 796)
POPUP = (60, 560, 760, 335)
MENU = (240, 180, 760, 460)
PIE = (0, 560, 760, 335)

CROPS: dict[str, tuple[str, str, tuple[int, int, int, int]]] = {
    # file: story, name of its picture, which part
    "start.jpg": ("first_time", "start", WINDOW),
    "add-menu.jpg": ("steps", "add-menu", VIEW),
    "plan.jpg": ("whole_day", "plan", WIDE),
    "redo.jpg": ("shell", "redo-panel", POPUP),
    "assigned.jpg": ("whole_day", "assigned", WIDE),
    "solved.jpg": ("whole_day", "solved", WINDOW),
    "dragging.jpg": ("whole_day", "dragging", WIDE),
    "fitted.jpg": ("first_time", "fitted", BESIDE),
    "deviation.jpg": ("approximate", "deviation", VIEW),
    "running.jpg": ("solving", "running", BESIDE),
    "flipped.jpg": ("solving", "flipped", BESIDE),
    "module.jpg": ("symmetry", "solved", BESIDE),
    "completed.jpg": ("symmetry", "completed", WIDE),
    "instances.jpg": ("symmetry", "instances", WIDE),
    "columns.jpg": ("whole_day", "completed", WIDE),
    "gap.jpg": ("periods", "gap", BESIDE),
    "closed.jpg": ("periods", "closed", BESIDE),
    "tiled.jpg": ("periods", "tiled", WIDE),
    "normals.jpg": ("overlay", "normals", VIEW),
    "tangent-planes.jpg": ("overlay", "tangent-planes", VIEW),
    "mirrors.jpg": ("overlay", "mirrors-solved", VIEW),
    "colours.jpg": ("colours", "gauss-curvature", WIDE),
    "curvature-lines.jpg": ("colours", "curvature-lines", VIEW),
    "gauss-image.jpg": ("colours", "gauss-image", WIDE),
    "presets.jpg": ("steps", "presets", MENU),
    "assign.jpg": ("steps", "assign", MENU),
    "pie.jpg": ("steps", "pie", PIE),
    "export.jpg": ("steps", "export", BESIDE),
    "list.png": ("list", "renamed", SIDEBAR),
}


def taken(story: str, name: str) -> Path | None:
    """The picture of this name, whatever its number."""
    pictures = sorted(TAKEN.glob(f"{story}-[0-9][0-9]-{name}.png"))
    return pictures[-1] if pictures else None


def crop(source: Path, target: Path, part: tuple[int, int, int, int]) -> None:
    """Part of a picture as a file, in the format of its suffix."""
    image = bpy.data.images.load(str(source))
    width, height = image.size
    pixels = np.empty(4 * width * height, dtype=np.float32)
    image.pixels.foreach_get(pixels)
    left, top, wide, high = part
    pixels = pixels.reshape(height, width, 4)[height - top - high : height - top, left : left + wide]
    cropped = bpy.data.images.new(target.stem, wide, high)
    cropped.pixels.foreach_set(np.ascontiguousarray(pixels).ravel())
    cropped.file_format = "JPEG" if target.suffix == ".jpg" else "PNG"
    for quality in (85, 75, 65, 55, 45):
        cropped.save(filepath=str(target), quality=quality)
        if target.suffix == ".png" or target.stat().st_size < LARGEST:
            break
    for used in (image, cropped):
        bpy.data.images.remove(used)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--taken", action="store_true", help="do not tell the stories, use the pictures in build/gui")
    if not parser.parse_args().taken:
        done = subprocess.run([str(RUN), *sorted({story for story, _, _ in CROPS.values()})])
        if done.returncode == IMPOSSIBLE:
            print("No window can be opened here; the pictures of the window stay as they are.")
            return 0
        if done.returncode:
            return done.returncode
    IMAGES.mkdir(parents=True, exist_ok=True)
    missing = []
    for file, (story, name, part) in CROPS.items():
        source = taken(story, name)
        if source is None:
            missing.append(f"{story}: {name}")
        else:
            crop(source, IMAGES / file, part)
    if missing:
        print(f"not taken: {', '.join(missing)}", file=sys.stderr)
    return 1 if missing else 0


if __name__ == "__main__":
    sys.exit(main())
