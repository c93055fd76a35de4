"""Run one story in a Blender window: blender --enable-event-simulate --python tell.py -- STORY

A story is a file in stories/ with `tell(hands)`, a generator that acts, yields seconds to wait, and asserts.
Prints "passed STORY" and ends Blender with 0, or prints the traceback and ends it with 3: an exception alone
would leave Blender running and its exit code 0.
"""

import importlib.util
import os
import sys
import traceback
from pathlib import Path

import addon_utils
import bpy

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))

from hands import Hands  # noqa: E402

EXTENSION = "bl_ext.user_default.cmc_formfinding"
STORY = sys.argv[sys.argv.index("--") + 1]


def load(name: str):
    spec = importlib.util.spec_from_file_location(name, HERE / "stories" / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def prepare() -> None:
    """The installed extension, no splash, an empty scene, the viewport as large as the window."""
    failures = []
    addon_utils.enable(EXTENSION, default_set=True, handle_error=failures.append)
    if failures:
        raise failures[0]
    from_its_wheels()
    bpy.context.preferences.view.show_splash = False
    dress()
    for ob in list(bpy.data.objects):
        bpy.data.objects.remove(ob)


def dress() -> None:
    """Blender's theme for these stories; factory settings are the dark one."""
    presets = Path(bpy.utils.system_resource("SCRIPTS"), "presets", "interface_theme")
    theme = presets / f"Blender_{os.environ.get('CMC_GUI_THEME', 'dark').title()}.xml"
    bpy.ops.script.execute_preset(filepath=str(theme), menu_idname="USERPREF_MT_interface_theme_presets")


def from_its_wheels() -> None:
    """What is tested is what users get: nothing out of the checkout, nor out of this system's Python."""
    import scipy

    for file in (sys.modules[EXTENSION].__file__, scipy.__file__):
        assert Path(file).is_relative_to(os.environ["BLENDER_USER_RESOURCES"]), file


def whole():
    prepare()
    yield 0.5
    hands = Hands(STORY)
    with bpy.context.temp_override(window=hands.window, area=hands.area):
        bpy.ops.screen.screen_full_area(use_hide_panels=False)
    yield 0.5
    yield from hands.open_tab()
    yield from load(STORY).tell(hands)


_steps = whole()


def tick() -> float:
    try:
        return next(_steps)
    except StopIteration:
        code = 0
        print(f"passed {STORY}", flush=True)
    except BaseException:
        code = 3
        traceback.print_exc()
        print(f"failed {STORY}", flush=True)
        try:
            import subprocess

            subprocess.run(["import", "-window", "root", f"/pictures/{STORY}-failed.png"], check=False)
        except OSError:
            pass
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)


bpy.app.timers.register(tick, first_interval=2.0, persistent=True)  # stories load files
