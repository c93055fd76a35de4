#!/usr/bin/env bash
# Print the path of a working Python of the given version ("3.11"), or nothing and exit 1.
# Looked for on PATH and among the versions of pyenv; a shim that does not run is passed over.
set -u
version=$1

works() {
  "$1" -c "import sys; sys.exit('%d.%d' % sys.version_info[:2] != '$version')" >/dev/null 2>&1
}

candidates() {
  type -ap "python$version" python3 python
  ls -d "${PYENV_ROOT:-$HOME/.pyenv}"/versions/"$version"*/bin/python 2>/dev/null
}

while read -r python; do
  if works "$python"; then
    echo "$python"
    exit 0
  fi
done < <(candidates)
exit 1
