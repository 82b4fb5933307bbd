#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# narrow.sh PROGRAM: a program of diffuse surfaces that stand still in vacuum must hold no code for anything else.
set -euo pipefail
if ! command -v nm > /dev/null; then
  echo "skipped: nm is not installed"
  exit 77
fi
count=$(nm -C "$1" | grep -c " [tTwW] manylight::" || true)
((count > 20)) || { echo "$1 has $count functions of manylight: is it stripped?"; exit 1; }
effects="transmitted|MediumInteraction|SceneMedia|Surfacing|Submersion|random_lines|Instants<|connect_below"
if nm -C "$1" | grep -E "manylight::.*($effects|HenyeyGreenstein|Dielectric)"; then
  echo "$1 has code for what its scene does not have"
  exit 1
fi
echo "$count functions of manylight, none for media, subsurface scattering, motion or glass"
