#!/bin/bash
# run.sh [STORY…]: drive a real Blender window without a screen and take pictures of it, into build/gui/. The
# extension is built for that Blender's Python and installed as users install it.
# run.sh --possible: only reports whether a window is possible here.
# CMC_GUI_THEME=light runs them in Blender's light theme, with pictures in build/gui/light/ (default: dark). CMC_GUI_ROOT is
# the folder of the Debian with Blender, made if it is missing (default: .venvs/gui-root), CMC_GUI_JOBS how many stories run
# at a time (default: as many as there are processors), CMC_GUI_LIMIT how many seconds a story may take (default: 600).
# Exits 0 if every story passed, 1 if one failed, 2 if no window is possible here.
set -euo pipefail
HERE=$(cd "$(dirname "$0")" && pwd)
CHECKOUT=$(cd "$HERE/../.." && pwd)
ROOT=${CMC_GUI_ROOT:-$CHECKOUT/.venvs/gui-root}
THEME=${CMC_GUI_THEME:-dark}
PICTURES=$CHECKOUT/build/gui
[ "$THEME" = dark ] || PICTURES=$PICTURES/$THEME  # those of the dark theme are in the documentation
# A namespace of its own for everything: mounts and processes vanish with the command, two runs at a time cannot
# see each other's screens, and nothing can be fetched.
ALONE=(unshare --mount --pid --net --ipc --fork --kill-child)

impossible() { echo "the tests of the window cannot be run here: $1" >&2; exit 2; }
[ "$(id -u)" = 0 ] || impossible "they need root, to install Blender into a folder of its own"
"${ALONE[@]}" chroot / true 2>/dev/null || impossible "this system allows no unshare or no chroot"
[ "${1-}" != --possible ] || exit 0
case $THEME in dark | light) ;; *) echo "CMC_GUI_THEME is dark or light, not $THEME" >&2; exit 2 ;; esac
[ -x "$CHECKOUT/.venv/bin/python" ] || impossible "there is no .venv yet; make gui-test sets it up"

mkdir -p "$PICTURES"
"$HERE/setup_chroot.sh" "$ROOT" || impossible "Blender could not be installed into $ROOT"

# One build at a time, and a copy: the next may begin before this one is installed.
SCRATCH=$(mktemp -d)
trap 'rm -rf "$SCRATCH"' EXIT
PYTHON=$(cat "$ROOT/.python")
(
  flock 9
  "$CHECKOUT/.venv/bin/python" "$CHECKOUT/scripts/build/build_extension.py" --python "$PYTHON" --output "$SCRATCH" >/dev/null
) 9>"$CHECKOUT/build/gui/.lock"

# The checkout cannot be written to, apart from build/gui.
export ROOT CHECKOUT SCRATCH PICTURES THEME
"${ALONE[@]}" bash -euc '
  mkdir -p "$ROOT/checkout" "$ROOT/pictures"
  mount -t proc proc "$ROOT/proc"
  mount --rbind /dev "$ROOT/dev"
  mount -t tmpfs tmpfs "$ROOT/tmp"
  cp "$SCRATCH"/*.zip "$ROOT/tmp/extension.zip"
  mount --bind "$CHECKOUT" "$ROOT/checkout"
  mount -o remount,bind,ro "$ROOT/checkout"
  mount --bind "$PICTURES" "$ROOT/pictures"
  exec chroot "$ROOT" env -i PATH=/usr/bin:/bin:/usr/games HOME=/tmp LC_ALL=C.UTF-8 LIBGL_ALWAYS_SOFTWARE=1 \
    PYTHONDONTWRITEBYTECODE=1 MESA_SHADER_CACHE_DIR=/var/cache/mesa CMC_GUI_JOBS="${CMC_GUI_JOBS-}" CMC_GUI_LIMIT="${CMC_GUI_LIMIT-}" \
    CMC_GUI_THEME="$THEME" \
    python3 /checkout/tests/gui/in_chroot.py "$@"' run "$@"
