#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# examples/demo.sh [--quick]: from a fresh clone on Debian 12 to a picture. Installs what is missing, builds
# manylight-render (with the built-in BVH only: half the compile time) and renders examples/scenes/glossy_room.xml with
# bidirectional lightcuts; --quick: a tiny picture by a program compiled in less time.
set -euo pipefail
cd "$(dirname "$0")/.."
source cmake/packages.sh

options=(--size 400x250 --eye-paths 16 --vpls 100000)
optimisation="-O3"
case "${1:-}" in
  "") ;;
  --quick) options=(--size 48x30 --eye-paths 2 --vpls 2000) optimisation="-O1" ;;
  *) echo "usage: examples/demo.sh [--quick]" >&2; exit 2 ;;
esac

echo "==== packages"
cmake/install_packages.sh "${packages_program[@]}"

mkdir -p build out
echo "==== building manylight-render in build/demo"
cmake -S . -B build/demo -G Ninja -D CMAKE_BUILD_TYPE=Release -D CMAKE_CXX_FLAGS_RELEASE="$optimisation -DNDEBUG" \
  -D CMAKE_UNITY_BUILD=ON -D MANYLIGHT_BUILD_TESTS=OFF \
  -D MANYLIGHT_BUILD_EXAMPLES=OFF -D MANYLIGHT_WITH_EMBREE=OFF >build/demo.log 2>&1 || { cat build/demo.log >&2; exit 1; }
cmake --build build/demo --target manylight-render --parallel "$(nproc)"

echo "==== rendering examples/scenes/glossy_room.xml"
build/demo/programs/manylight-render examples/scenes/glossy_room.xml --method bdlc "${options[@]}" \
  --output out/glossy_room.png --output out/glossy_room.exr --stats out/glossy_room.json
echo "==== done in $SECONDS s: out/glossy_room.png to look at, out/glossy_room.exr to measure," \
  "out/glossy_room.json for what it cost"
