#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# benchmarks/charts.sh [-n NAME]... [-o FOLDER] [-s REFERENCE_SCENES] [OPTION...]: options of manylight-chart after --.
# Charts error over time of every scene in examples/scenes and, below REFERENCE_SCENES, of those that have a
# reference-path-WxH.exr beside them, with that as the truth, and of six others; -n charts only the scenes named (-l
# lists them). All goes to FOLDER (out/charts), one folder per scene, and one table of all to summary.md there; what is
# there already is not rendered again. Takes hours; --budget S says how long one rendering may take.
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
source "$root/cmake/packages.sh"

output=$root/out/charts
references=
wanted=()
list=
usage() {
  echo "usage: benchmarks/charts.sh [-l] [-n NAME]... [-o FOLDER] [-s REFERENCE_SCENES] [OPTION...]" >&2
  exit 2
}
while getopts ln:o:s: option; do
  case $option in
    l) list=yes ;;
    n) wanted+=("$OPTARG") ;;
    o) output=$OPTARG ;;
    s) references=$OPTARG ;;
    *) usage ;;
  esac
done
shift $((OPTIND - 1))
[[ ${1:-} != -- ]] || shift
output=$(realpath -m --relative-base="$root" "$output")  # as it should stand in the commands that the table gives
[[ -z $references ]] || references=$(realpath -e --relative-base="$root" "$references")
cd "$root"

# scene NAME FILE WxH OPTION...: one to chart.
names=()
declare -A files options
scene() {
  names+=("$1")
  files[$1]=$2
  options[$1]=$(printf '%s\n' --width "${3%x*}" --height "${3#*x}" "${@:4}")
}

# Relative variance of the 4,096 samples per pixel in references beside scenes: a seventeenth of that renderer's own error
# at 256, which holds the variance of both. A reference that is not named here counts as exact.
declare -A noises=([modern-hall]=0.0009 [living-room]=0.0025 [sponza]=0.0019)

made=$output/scenes
scene cornell examples/scenes/cornell.xml 200x160
scene glossy_room examples/scenes/glossy_room.xml 200x125
scene cafe_table examples/scenes/cafe_table.xml 200x125
scene moving_lamp examples/scenes/moving_lamp.xml 180x120
scene lantern_hall "$made/lantern_hall/lantern_hall.xml" 200x125
scene cafe_figure "$made/cafe_figure/cafe_figure.xml" 200x125
scene kitchen "$made/kitchen/kitchen.xml" 180x120
# make_scene NAME: writes the file of a scene that is not kept here.
make_scene() {
  [[ ! -e ${files[$1]} ]] || return 0
  case $1 in
    lantern_hall | cafe_figure) examples/scenes/generate.py "$1" "$made/$1" >/dev/null ;;
    kitchen) examples/scenes/kitchen.py "$made/kitchen" >/dev/null ;;
  esac
}

if [[ -n $references ]]; then
  while IFS= read -r reference; do
    folder=$(dirname "$reference")
    name=$(basename "$folder")
    pixels=$(basename "$reference" .exr)
    file=$(find "$folder" -maxdepth 1 -name '*.xml' | sort | head -1)
    [[ -n $file ]] || { echo "$folder: no scene beside the reference" >&2; continue; }
    # Such references hold 12 edges and have a box filter, whatever the scene file says.
    scene "$name" "$file" "${pixels#reference-path-}" --reference "$reference" \
      --reference-noise "${noises[$name]:-0}" --with max-depth=12 --with filter=box
  done < <(find "$references" -name 'reference-path-*x*.exr' | sort)
  other() { [[ ! -e $references/$2 ]] || scene "$1" "$references/$2" "$3"; }
  other cornell-box cornell-box/scene.xml 160x160
  other veach-mis veach-mis/scene.xml 192x108
  other hetvol hetvol/hetvol.xml 192x144
  other vol-cbox vol-cbox/vol_cbox.xml 128x128
  other sss-bunny sss-bunny/docs/scenes/medium_homogeneous_sss.xml 160x120
  other matpreview matpreview-roughplastic/docs/scenes/bsdf_roughplastic_ggx.xml 160x120
fi

if [[ -n $list ]]; then
  printf '%s\n' "${names[@]}"
  exit 0
fi
for name in "${wanted[@]}"; do
  [[ -n ${files[$name]:-} ]] || { echo "charts.sh: no scene '$name'; there are ${names[*]}" >&2; exit 2; }
done
[[ ${#wanted[@]} -gt 0 ]] || wanted=("${names[@]}")

mkdir -p "$output"
"$root/cmake/install_packages.sh" "${packages_program[@]}" python3-matplotlib
render=${MANYLIGHT_RENDER:-}
if [[ -z $render ]]; then
  cmake --preset release >"$output/build.log"
  cmake --build --preset release --target manylight-render >>"$output/build.log"
  render=$root/build/release/programs/manylight-render
fi

# Charts tell which methods are not for their scene; a scene that cannot be charted does not keep others from it.
methods=path,bdpt,pppm,photonmap,vpl,ir+compensate,lightcuts,bdlc
failed=0
for name in "${wanted[@]}"; do
  echo "==== $name"
  make_scene "$name"
  mapfile -t given <<<"${options[$name]}"
  programs/chart/manylight-chart "${files[$name]}" --methods "$methods" "${given[@]}" "$@" --render "$render" \
    -o "$output/$name" </dev/null || failed=$((failed + 1))
done
programs/chart/manylight-chart --summary "$output" >"$output/summary.md" || failed=$((failed + 1))
echo "==== charts in $output: NAME/chart.html, summary.md"
[[ $failed -eq 0 ]] || { echo "$failed scenes could not be charted" >&2; exit 1; }
