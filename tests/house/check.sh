#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# check.sh layers|umbrella|citations|files|readme|options: one house rule each; prints what breaks it.
# options is followed by the paths of manylight-render and manylight-compare.
set -euo pipefail
cd "$(dirname "$0")/../.."
failures=0
fail() {
  echo "$*"
  failures=$((failures + 1))
}
headers() { find include/manylight -name '*.hpp' | sort; }

# A lower layer never includes an upper one.
check_layers() {
  local order=(core geometry scattering bounds media scene path many_light integrator)
  local -A rank
  local i layer file included
  for i in "${!order[@]}"; do rank[${order[i]}]=$i; done
  for file in $(headers); do
    layer=$(cut -s -d/ -f3 <<<"$file")
    [[ -n $layer && -n ${rank[$layer]:-} ]] || continue
    for included in $(sed -nE 's|^#include "manylight/([a-z_]+)/.*|\1|p' "$file" | sort -u); do
      [[ -n ${rank[$included]:-} ]] || { fail "$file includes the unknown layer '$included'"; continue; }
      ((rank[$included] <= rank[$layer])) || fail "$file ($layer) includes an upper layer, $included"
    done
  done
}

# The umbrella holds every header but the bridges to optional packages.
check_umbrella() {
  local name
  for name in $(headers | sed 's|^include/||'); do
    case $name in
      manylight/manylight.hpp | manylight/fwd.hpp) continue ;;
      manylight/core/tbb_executor.hpp | manylight/geometry/embree.hpp | manylight/geometry/embree_scene.hpp)
        ! grep -q "\"$name\"" include/manylight/manylight.hpp || fail "the umbrella includes the bridge $name" ;;
      *) grep -q "^#include \"$name\"" include/manylight/manylight.hpp || fail "the umbrella lacks $name" ;;
    esac
  done
}

# Every citation, [Surname ... year ...], stands in docs/references.md under its first author and year.
check_citations() {
  local citation surname year
  while IFS= read -r citation; do
    surname=$(grep -oE '^[A-Z][A-Za-z-]+' <<<"$citation")
    year=$(grep -oE '(19|20)[0-9]{2}' <<<"$citation" | head -1)
    grep -qE "^\| $surname[^|]* $year" docs/references.md || fail "docs/references.md lacks [$citation]"
  done < <(grep -rhoE '\[[A-Z][A-Za-z-]+[^]"]*(19|20)[0-9]{2}[^]]*\]' include programs docs \
    --include=*.hpp --include=*.cpp --include=*.md | tr -d '[]' | sed -E 's/; */\n/g' |
    grep -E '^[A-Z].*(19|20)[0-9]{2}' | sort -u)
}

# First lines, sizes, macros, streams and virtuals of headers.
check_files() {
  local file lines
  while IFS= read -r file; do
    head -2 "$file" | grep -q 'SPDX-License-Identifier: Apache-2.0' || fail "$file: no SPDX line on top"
    if grep -nP '\t| +$' "$file" | head -3; then fail "$file: tab or trailing space"; fi
    # clang-format breaks at 120; what it leaves alone (comments, strings) may pass that by a word.
    if awk 'length($0) > 128 { print FILENAME ":" FNR ": " length($0); bad = 1 } END { exit !bad }' "$file"; then
      fail "$file: line far beyond 120 columns"
    fi
  done < <(find include programs tests examples benchmarks -name '*.hpp' -o -name '*.cpp' -o -name '*.sh' | sort)
  for file in $(headers); do
    grep -qx '#pragma once' "$file" || fail "$file: no #pragma once"
    lines=$(wc -l <"$file")
    ((lines <= 400)) || fail "$file: $lines lines, at most 400"
    if [[ $file != include/manylight/core/config.hpp ]] && grep -nE '^ *# *define' "$file"; then
      fail "$file: defines a macro; they stand in core/config.hpp"
    fi
    if grep -nE '#include <(iostream|fstream|cstdio|ranges|regex)>|std::function|^ *virtual ' "$file"; then
      fail "$file: not for headers"
    fi
  done
}

# The program in the README is examples/quickstart.cpp; its links lead somewhere; its commands exist.
check_readme() {
  local link command
  if ! diff <(awk '/^```cpp$/ { on = 1; next } /^```$/ { if (on) exit } on' README.md) \
    <(grep -v '^// SPDX' examples/quickstart.cpp); then
    fail "the program in README.md differs from examples/quickstart.cpp (its SPDX line apart)"
  fi
  for link in $(grep -ohE '\]\([^)#:]+\)' README.md CONTRIBUTING.md | tr -d '()]'); do
    [[ -e $link ]] || fail "README.md or CONTRIBUTING.md links to $link, which does not exist"
  done
  for command in examples/demo.sh tests/run.sh; do
    grep -qx "    $command" README.md || fail "README.md does not give the command $command on a line of its own"
    [[ -x $command ]] || fail "$command is not executable"
  done
}

# Every long option of the programs is documented, and none that does not exist.
check_options() {
  local known documented
  known=$({ "$1" --help; "$2" --help; } | grep -oE -- '--[a-z][a-z-]+' | grep -vxE -- '--(help|version)' | sort -u)
  documented=$(grep -oE -- '`[^`]*`|^    manylight-.*' docs/program.md | grep -oE -- '--[a-z][a-z-]+' |
    grep -vx -- --help | sort -u)
  diff <(echo "$known") <(echo "$documented") || fail "docs/program.md (>) and --help (<) differ"
}

"check_$1" "${@:2}"
echo "$1: $failures failures"
[[ $failures -eq 0 ]]
