#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# tests/run.sh: installs what is missing (Debian 12), builds and runs all tests.
# tests/run.sh --ci: before that, clang++ with sanitizers, a build without the optional packages, the demo at a small
#   size and the compile times; warnings are errors throughout.
# MANYLIGHT_REFERENCE_SCENES=FOLDER in the environment adds the tests against reference images.
set -euo pipefail
cd "$(dirname "$0")/.."
source cmake/packages.sh

ci=false
case "${1:-}" in
  "") ;;
  --ci) ci=true ;;
  *) echo "usage: tests/run.sh [--ci]" >&2; exit 2 ;;
esac

jobs=$(nproc)
stage_name=""
stage() {
  finish_stage
  stage_name=$1 stage_start=$SECONDS
  echo
  echo "==== $stage_name"
}
finish_stage() {
  if [[ -n $stage_name ]]; then echo "==== $stage_name: done in $((SECONDS - stage_start)) s"; fi
}
trap 'status=$?; if [[ $status -ne 0 ]]; then echo "==== FAILED in: $stage_name (exit $status)" >&2; fi' EXIT

# build_and_test PRESET [CMAKE OPTION...]
build_and_test() {
  local preset=$1
  shift
  cmake --preset "$preset" "$@"
  cmake --build --preset "$preset" --parallel "$jobs"
  ctest --preset "$preset" --parallel "$jobs"
}

scenes=${MANYLIGHT_REFERENCE_SCENES:-}
if $ci && [[ -z $scenes && -d ../shared/scenes ]]; then scenes=$(cd ../shared/scenes && pwd); fi

stage "packages"
packages=("${packages_program[@]}" "${packages_tests[@]}")
if $ci; then packages+=("${packages_ci[@]}"); fi
cmake/install_packages.sh "${packages[@]}"

if $ci; then
  stage "clang++, address and undefined-behaviour sanitizers, quick tests"
  build_and_test asan
  stage "without Embree, oneTBB and NanoVDB, generic processor, quick tests"
  build_and_test bare
  stage "demo at a small size"
  examples/demo.sh --quick
  stage "compile times"
  tests/compile_budget.sh
fi

stage "g++, release, all tests"
if [[ -n $scenes ]]; then
  echo "reference scenes: $scenes"
else
  echo "reference scenes not given: tests against them skipped"
fi
build_and_test release -D MANYLIGHT_REFERENCE_SCENES="$scenes" \
  -D MANYLIGHT_WARNINGS_AS_ERRORS="$(if $ci; then echo ON; else echo OFF; fi)"
finish_stage
