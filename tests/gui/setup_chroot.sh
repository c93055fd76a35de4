#!/bin/bash
# setup_chroot.sh ROOT: a Debian sid below ROOT, with its Blender (5.2 or newer) and what the tests of the
# window need. About 1.5 GB and two minutes, once; again only when the list of packages has changed. Needs root;
# debootstrap is installed if it is missing. scipy and trimesh must not be in it: the extension brings its own.
set -euo pipefail
ROOT=$1
PACKAGES="blender python3-numpy python3-requests python3-zstandard python3-cattr
  xvfb xauth imagemagick tesseract-ocr tesseract-ocr-eng libgl1-mesa-dri libegl1 fonts-dejavu-core"
PACKAGES=$(echo $PACKAGES)

[ -e "$ROOT/.ready" ] && [ "$(cat "$ROOT/.ready")" = "$PACKAGES" ] && exit 0
if [ "$(id -u)" != 0 ]; then
  echo "the tests of the window need root: they install Blender into a folder of its own" >&2
  exit 2
fi
LOG=$(mktemp)
trap 'code=$?; [ $code = 0 ] || tail -n 30 "$LOG" >&2; rm -f "$LOG"' EXIT
if ! command -v debootstrap >/dev/null; then
  apt-get update -qq >>"$LOG" 2>&1
  apt-get install -y -qq --no-install-recommends debootstrap >>"$LOG" 2>&1
fi
echo "installing Blender into $ROOT, once"
mkdir -p "$ROOT"
if [ ! -e "$ROOT/.bootstrapped" ]; then  # a half-made one is begun again
  debootstrap --variant=minbase --include=ca-certificates sid "$ROOT" >>"$LOG" 2>&1
  touch "$ROOT/.bootstrapped"
fi
cp /etc/resolv.conf "$ROOT/etc/resolv.conf"
# The index of a rolling suite can look expired; its signature is still checked.
chroot "$ROOT" env DEBIAN_FRONTEND=noninteractive LC_ALL=C sh -eu -c "
  apt-get -o Acquire::Check-Valid-Until=false update -qq
  apt-get install -y -qq --no-install-recommends $PACKAGES
  apt-get clean" >>"$LOG" 2>&1
# Which Python this Blender is built for: the extension's wheels must be for it.
chroot "$ROOT" env HOME=/tmp blender --background --factory-startup \
  --python-expr 'import sys; print("Python", "%d.%d" % sys.version_info[:2])' 2>>"$LOG" |
  sed -n 's/^Python //p' >"$ROOT/.python"
grep -q '^3\.' "$ROOT/.python"
echo "$PACKAGES" >"$ROOT/.ready"
