#!/bin/bash
# in_chroot.sh [STORY…]: inside the Debian with Blender. Each story has a Blender of its own.
set -uo pipefail
export BLENDER_USER_RESOURCES=/tmp/blender
mkdir -p $BLENDER_USER_RESOURCES/scripts/addons
ln -sfn /checkout $BLENDER_USER_RESOURCES/scripts/addons/cmc_formfinding

STORIES=${*:-$(cd /checkout/tests/gui/stories && ls *.py | sed 's/\.py$//')}
failed=0
for story in $STORIES; do
  rm -f /pictures/$story-*.png
  echo "--- $story"
  timeout 300 xvfb-run -a -s "-screen 0 1280x960x24 +extension GLX" \
    blender --factory-startup --enable-event-simulate --window-geometry 0 0 1280 960 \
    --python /checkout/tests/gui/tell.py -- "$story" >/pictures/$story.log 2>&1
  code=$?
  grep -E '^(told|failed)' /pictures/$story.log
  if [ $code != 0 ] || ! grep -q '^told' /pictures/$story.log; then
    failed=1
    tail -n 30 /pictures/$story.log
  fi
done
exit $failed
