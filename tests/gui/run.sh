#!/bin/bash
# run.sh [STORY…]: drive a real Blender window without a screen and take pictures of it, into build/gui/.
# CMC_GUI_ROOT says where the Debian with Blender is or is to be made (default: .venvs/gui-root).
# Exits 0 if every story went as told.
set -euo pipefail
HERE=$(cd "$(dirname "$0")" && pwd)
CHECKOUT=$(cd "$HERE/../.." && pwd)
ROOT=${CMC_GUI_ROOT:-$CHECKOUT/.venvs/gui-root}
mkdir -p "$CHECKOUT/build/gui"
"$HERE/setup_chroot.sh" "$ROOT"

# Mounts live in a namespace of their own and vanish with the command. The checkout cannot be written to,
# apart from build/gui.
export ROOT CHECKOUT
exec unshare --mount bash -euc '
  mount -t proc proc "$ROOT/proc"
  mount --rbind /dev "$ROOT/dev"
  mount -t tmpfs tmpfs "$ROOT/tmp"
  mkdir -p "$ROOT/checkout" "$ROOT/pictures"
  mount --bind "$CHECKOUT" "$ROOT/checkout"
  mount -o remount,bind,ro "$ROOT/checkout"
  mount --bind "$CHECKOUT/build/gui" "$ROOT/pictures"
  exec chroot "$ROOT" env -i PATH=/usr/bin:/bin:/usr/games HOME=/tmp LC_ALL=C.UTF-8 LIBGL_ALWAYS_SOFTWARE=1 \
    PYTHONDONTWRITEBYTECODE=1 /checkout/tests/gui/in_chroot.sh "$@"' run "$@"
