#!/usr/bin/env bash
# Install what a bare Debian lacks: shared libraries that Blender's Python module loads, and Python's
# venv module where Debian split it off. Does nothing, and needs no rights, where all is there.
set -eu
python=$1

[ "$(uname -s)" = Linux ] || exit 0

# a line each: what the dynamic loader looks for, the Debian package that has it
libraries="
libX11.so.6        libx11-6
libXrender.so.1    libxrender1
libXfixes.so.3     libxfixes3
libXi.so.6         libxi6
libxkbcommon.so.0  libxkbcommon0
libSM.so.6         libsm6
libICE.so.6        libice6
libGL.so.1         libgl1
"

known=$(PATH=$PATH:/sbin:/usr/sbin ldconfig -p)
missing=()
while read -r library package; do
  [ -n "$library" ] || continue
  case "$known" in *"$library "*) ;; *) missing+=("$package") ;; esac
done <<<"$libraries"

if ! "$python" -c 'import ensurepip, venv' >/dev/null 2>&1; then
  missing+=("$("$python" -c 'import sys; print("python%d.%d-venv" % sys.version_info[:2])')")
fi

[ ${#missing[@]} -gt 0 ] || exit 0

if ! command -v apt-get >/dev/null || [ "$(id -u)" -ne 0 ]; then
  echo "Blender's Python module needs system libraries that are not here. On Debian or Ubuntu:" >&2
  echo "    sudo apt-get update && sudo apt-get install ${missing[*]}" >&2
  exit 1
fi

echo "Installing missing system libraries with apt-get: ${missing[*]}"
export DEBIAN_FRONTEND=noninteractive
apt-get update -qq
apt-get install -qq -y --no-install-recommends "${missing[@]}" >/dev/null
