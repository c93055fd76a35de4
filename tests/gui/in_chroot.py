"""in_chroot.py [STORY…]: inside the Debian with Blender. Installs the extension, runs the stories, by default all, each
in a Blender and on a screen of its own, and sums up. Exits 1 if a story fails.
"""

from __future__ import annotations

import os
import resource
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

HERE = Path(__file__).parent
PICTURES = Path("/pictures")
ARCHIVE = Path("/tmp/extension.zip")
USER = Path("/tmp/blender")
INSTALLED = USER / "extensions" / "user_default" / "cmc_formfinding" / "blender_manifest.toml"
LIMIT = float(os.environ.get("CMC_GUI_LIMIT") or 600)  # seconds for a story; a quiet machine takes a tenth or two
WIDTH, HEIGHT = 1280, 900


def install() -> None:
    """The zip, by Blender's own command; whose exit code says nothing."""
    USER.mkdir()
    command = ["blender", "--command", "extension", "install-file", "-r", "user_default", "--enable", str(ARCHIVE)]
    done = subprocess.run(command, env=surroundings(), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if not INSTALLED.exists():
        sys.exit(f"the extension could not be installed:\n{done.stdout}")


def surroundings(display: str = "", story: str = "") -> dict[str, str]:
    """Every story saves into a home of its own."""
    home = Path("/tmp/home", story)
    home.mkdir(parents=True, exist_ok=True)
    return {**os.environ, "BLENDER_USER_RESOURCES": str(USER), "DISPLAY": display, "HOME": str(home)}


def run(story: str) -> tuple[str, bool, float]:
    """Run one story; its name, whether it passed, and its seconds."""
    for old in PICTURES.glob(f"{story}-*.png"):
        old.unlink()
    begun = time.monotonic()
    log = PICTURES / f"{story}.log"
    with log.open("w") as output:
        code = in_window(story, output)
    seconds = time.monotonic() - begun
    text = log.read_text(errors="replace")
    passed = code == 0 and f"passed {story}\n" in text and "Traceback" not in text  # a panel's, which stops nothing
    pictures = len(list(PICTURES.glob(f"{story}-*.png")))
    print(f"{'passed' if passed else 'FAILED'} {story:12s} {seconds:4.0f} s, {pictures} pictures", flush=True)
    if not passed:
        reason = f"it took longer than {LIMIT:.0f} s" if code is None else "\n".join(text.splitlines()[-30:])
        print(reason, flush=True)
    return story, passed, seconds


def in_window(story: str, output) -> int | None:
    """Blender's exit code; None if it had to be ended."""
    screen = [f"{WIDTH}x{HEIGHT}x24"]
    server = subprocess.Popen(
        ["Xvfb", "-displayfd", "1", "-screen", "0", *screen, "+extension", "GLX", "-nolisten", "tcp"],
        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
    )
    blender = None
    try:
        display = ":" + server.stdout.readline().strip()
        command = ["blender", "--factory-startup", "--enable-event-simulate"]
        command += ["--window-geometry", "0", "0", str(WIDTH), str(HEIGHT)]
        command += ["--python", str(HERE / "tell.py"), "--", story]
        blender = subprocess.Popen(command, env=surroundings(display, story), stdout=output, stderr=subprocess.STDOUT)
        return blender.wait(LIMIT)
    except subprocess.TimeoutExpired:
        subprocess.run(["import", "-window", "root", PICTURES / f"{story}-failed.png"], env=surroundings(display))
        return None
    finally:
        for process in (blender, server):
            if process is not None:
                process.kill()
                process.wait()


def minutes(seconds: float) -> str:
    return "{}:{:02d}".format(*divmod(round(seconds), 60))


def main(stories: list[str]) -> int:
    signal.signal(signal.SIGTERM, lambda *_: os._exit(143))  # the first process of a namespace would ignore it
    begun = time.monotonic()
    files = (HERE / "stories").glob("*.py")
    known = sorted(path.stem for path in files if "\ndef tell(" in path.read_text())
    unknown = set(stories) - set(known)
    if unknown:
        sys.exit(f"there is no story {', '.join(sorted(unknown))}; there are {', '.join(known)}")
    install()
    jobs = int(os.environ.get("CMC_GUI_JOBS") or os.cpu_count() or 1)
    with ThreadPoolExecutor(jobs) as pool:
        results = list(pool.map(run, stories or known))
    failed = [story for story, passed, _ in results if not passed]
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    took, worked = minutes(time.monotonic() - begun), minutes(used.ru_utime + used.ru_stime)
    passed = len(results) - len(failed)
    print(f"{passed} of {len(results)} stories passed, in {took} minutes, {worked} of processor time")
    for story in failed:
        print(f"  not {story}: {story}.log, {story}-failed.png, beside the other pictures")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
