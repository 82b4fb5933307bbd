#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# benchmarks/charts.sh [-o FOLDER] [-s REFERENCE_SCENES] [OPTION...]: options of manylight-chart after --.
# Charts error over time of every scene in examples/scenes, and of the scenes below REFERENCE_SCENES that have a
# reference-path-WxH.exr beside them, with that as the truth. All goes to FOLDER (out/charts), one folder per scene;
# what is there already is not rendered again. Takes hours; --budget S says how long one rendering may take.
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
source "$root/cmake/packages.sh"

output=$root/out/charts
references=
while getopts o:s: option; do
  case $option in
    o) output=$OPTARG ;;
    s) references=$OPTARG ;;
    *) echo "usage: benchmarks/charts.sh [-o FOLDER] [-s REFERENCE_SCENES] [OPTION...]" >&2; exit 2 ;;
  esac
done
shift $((OPTIND - 1))
[[ ${1:-} != -- ]] || shift
mkdir -p "$output"
output=$(cd "$output" && pwd)

"$root/cmake/install_packages.sh" "${packages_program[@]}" python3-matplotlib
cd "$root"
render=${MANYLIGHT_RENDER:-}
if [[ -z $render ]]; then
  cmake --preset release >"$output/build.log"
  cmake --build --preset release --target manylight-render >>"$output/build.log"
  render=$root/build/release/programs/manylight-render
fi

failed=0
# chart NAME SCENE OPTION...: a scene that cannot be charted does not keep others from it.
chart() {
  local name=$1
  shift
  echo "==== $name"
  programs/chart/manylight-chart "$@" --render "$render" -o "$output/$name" </dev/null || failed=$((failed + 1))
}

examples/scenes/generate.py lantern_hall "$output/scenes/lantern_hall" >/dev/null
chart cornell examples/scenes/cornell.xml --width 200 --height 160 "$@"
chart glossy_room examples/scenes/glossy_room.xml --width 200 --height 125 "$@"
chart cafe_table examples/scenes/cafe_table.xml --width 200 --height 125 "$@"
chart lantern_hall "$output/scenes/lantern_hall/lantern_hall.xml" --width 200 --height 125 "$@"

if [[ -n $references ]]; then
  while IFS= read -r reference; do
    folder=$(dirname "$reference")
    size=$(basename "$reference" .exr)
    size=${size#reference-path-}
    scene=$(find "$folder" -maxdepth 1 -name '*.xml' | sort | head -1)
    [[ -n $scene ]] || { echo "$folder: no scene beside the reference" >&2; continue; }
    chart "$(basename "$folder")" "$scene" --width "${size%x*}" --height "${size#*x}" --reference "$reference" "$@"
  done < <(find "$references" -name 'reference-path-*x*.exr' | sort)
fi
echo "==== charts in $output: NAME/chart.html"
[[ $failed -eq 0 ]] || { echo "$failed scenes could not be charted" >&2; exit 1; }
