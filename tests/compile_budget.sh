#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Prints compile times as ratios to a unit that includes only GLM and nanoflann (best of 3, CPU seconds). Aims: the
# forward declarations below 0.3, a method with its instantiation below 4. It never fails on a time: machines differ.
set -euo pipefail
cd "$(dirname "$0")/.."
compiler=${CXX:-g++}
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

# seconds FILE [FLAG...]: best of 3
seconds() {
  local best="" time
  for _ in 1 2 3; do
    time=$( { TIMEFORMAT='%U %S'; time "$compiler" -std=c++20 -Iinclude "${@:2}" -o "$scratch/out.o" "$1"; } 2>&1 |
      awk '{ print $1 + $2 }')
    best=$(printf '%s\n' $best "$time" | sort -g | head -1)
  done
  echo "$best"
}
row() { awk -v name="$1" -v t="$2" -v base="$3" 'BEGIN { printf "%-44s %6.2f s  %5.2f x\n", name, t, t / base }'; }

printf '#include <glm/glm.hpp>\n#include <nanoflann.hpp>\n' >"$scratch/base.cpp"
base=$(seconds "$scratch/base.cpp" -fsyntax-only)
row "glm + nanoflann" "$base" "$base"
for header in fwd.hpp manylight.hpp integrator/path.hpp integrator/bidirectional_lightcuts.hpp; do
  [[ -f include/manylight/$header ]] || continue
  printf '#include "manylight/%s"\n' "$header" >"$scratch/unit.cpp"
  row "$header" "$(seconds "$scratch/unit.cpp" -fsyntax-only)" "$base"
done
if [[ -f examples/quickstart.cpp ]]; then
  row "examples/quickstart.cpp, checked" "$(seconds examples/quickstart.cpp -fsyntax-only)" "$base"
  row "examples/quickstart.cpp, -O2" "$(seconds examples/quickstart.cpp -O2 -c)" "$base"
fi
