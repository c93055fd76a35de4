#!/bin/bash
# setup_chroot.sh ROOT: a Debian sid below ROOT, with its Blender (5.2 or newer) and what the tests of the
# window need. About 1.5 GB and two minutes, once. Needs root; debootstrap is installed if it is missing.
set -euo pipefail
ROOT=$1
PACKAGES="blender python3-numpy python3-scipy python3-trimesh python3-requests python3-zstandard python3-cattr
  xvfb xauth imagemagick libgl1-mesa-dri libegl1 fonts-dejavu-core"

[ -e "$ROOT/.ready" ] && exit 0
if [ "$(id -u)" != 0 ]; then
  echo "the tests of the window need root: they install Blender into a folder of its own" >&2
  exit 2
fi
if ! command -v debootstrap >/dev/null; then
  apt-get update -qq
  apt-get install -y -qq --no-install-recommends debootstrap >/dev/null
fi
LOG=$(mktemp)
trap 'code=$?; [ $code = 0 ] || tail -n 30 "$LOG" >&2; rm -f "$LOG"' EXIT
echo "installing Blender into $ROOT, once"
if [ ! -x "$ROOT/usr/bin/apt-get" ]; then
  debootstrap --variant=minbase --include=ca-certificates sid "$ROOT" >>"$LOG" 2>&1
fi
cp /etc/resolv.conf "$ROOT/etc/resolv.conf"
# The index of a rolling suite can look expired; its signature is still checked.
chroot "$ROOT" env DEBIAN_FRONTEND=noninteractive LC_ALL=C sh -eu -c "
  apt-get -o Acquire::Check-Valid-Until=false update -qq
  apt-get install -y -qq --no-install-recommends $(echo $PACKAGES)
  apt-get clean" >>"$LOG" 2>&1
touch "$ROOT/.ready"
