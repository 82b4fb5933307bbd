#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# run.sh subdirectory|installed|plain COMPILER SOURCE SCRATCH [COMPONENTS]
# Builds and runs main.cpp the given way. SOURCE is the folder of manylight, SCRATCH is emptied.
set -euo pipefail
way=$1 compiler=$2 source=$3 scratch=$4 components=${5:-}
here=$(cd "$(dirname "$0")" && pwd)
rm -rf "$scratch"
mkdir -p "$scratch"

build_and_run() {
  cmake -S "$here/$way" -B "$scratch/build" -D CMAKE_CXX_COMPILER="$compiler" "$@"
  cmake --build "$scratch/build"
  "$scratch/build/consumer"
}

case $way in
  subdirectory)
    build_and_run -D MANYLIGHT_SOURCE="$source"
    ;;
  installed)
    # A build of its own, without programs: only headers and package are wanted.
    cmake -S "$source" -B "$scratch/manylight" -D CMAKE_CXX_COMPILER="$compiler" -D MANYLIGHT_BUILD_PROGRAMS=OFF \
      -D MANYLIGHT_BUILD_TESTS=OFF -D MANYLIGHT_BUILD_EXAMPLES=OFF -D CMAKE_INSTALL_PREFIX="$scratch/prefix"
    cmake --install "$scratch/manylight"
    rm -rf "$scratch/manylight"
    build_and_run -D CMAKE_PREFIX_PATH="$scratch/prefix" -D MANYLIGHT_COMPONENTS="${components//,/;}"
    ;;
  plain)
    "$compiler" -std=c++20 -I "$source/include" "$here/main.cpp" -o "$scratch/consumer"
    "$scratch/consumer"
    ;;
  *)
    echo "unknown way '$way'" >&2
    exit 2
    ;;
esac
