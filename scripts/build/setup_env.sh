#!/usr/bin/env bash
# Create a virtual environment, or bring it up to date with pyproject.toml.
#
#     scripts/build/setup_env.sh FOLDER PYTHON_VERSION NAME...
#
# NAMEs are those of scripts/build/requirements.py. When the requirements are those of the last time,
# nothing is done. The file FOLDER/ready is touched at the end: make's stamp.
set -eu
cd "$(dirname "$0")/../.."
folder=$1 version=$2
shift 2

if ! python=$(scripts/build/find_python.sh "$version"); then
  echo "No working Python $version on PATH or in ~/.pyenv/versions; Blender's module in $folder needs it." >&2
  exit 1
fi
scripts/build/system_libraries.sh "$python"

"$folder/bin/python" -m pip --version >/dev/null 2>&1 || "$python" -m venv --clear "$folder"
"$python" scripts/build/requirements.py "$@" >"$folder/requirements.txt.new"
if ! cmp -s "$folder/requirements.txt.new" "$folder/requirements.txt"; then
  echo "Installing into $folder: $(tr '\n' ' ' <"$folder/requirements.txt.new")"
  "$folder/bin/python" -m pip install --quiet --no-input -r "$folder/requirements.txt.new"
  mv "$folder/requirements.txt.new" "$folder/requirements.txt"
else
  rm "$folder/requirements.txt.new"
fi
touch "$folder/ready"
