#!/usr/bin/env bash
# Makes everything in docs/charts: charts, their CSVs, error maps, and the tables that go with them.
#
#     docs/make_charts.sh [PELLICLE]     default: target/release/pellicle
#
# Converged references are rendered anew and not kept. Takes a few minutes on a quiet machine.
set -euo pipefail
cd "$(dirname "$0")/.."
pellicle=$(realpath "${1:-target/release/pellicle}")
out=docs/charts
mkdir -p "$out"
cache=$(mktemp -d)
trap 'rm -rf "$cache"' EXIT
tables=$out/tables.md

model=$(grep -m1 '^model name' /proc/cpuinfo | sed 's/.*: //')
{
    echo "# Tables of the charts"
    echo
    echo "Written by \`docs/make_charts.sh\`; what they mean is said in [charts.md](../charts.md)."
    echo
    echo "Machine: $model, $(nproc) threads, Linux $(uname -r). Program: $("$pellicle" --version)."
} >"$tables"

table() { # title, command ...
    local title=$1
    shift
    local shown=$*
    echo "charting $title" >&2
    {
        printf '\n## %s\n\n    pellicle %s\n\n```\n' "$title" "${shown// --cache $cache/}"
        "$pellicle" "$@" 2>/dev/null
        echo '```'
    } >>"$tables"
}

table "Typical films" chart films -o "$out/films"
table "Cost growth" chart growth -o "$out/growth"

small=(--spp 4,16,64 --repeats 2 --reference-spp 768 --cache "$cache")
table "Titanium" chart convergence scenes/titanium.dae -o "$out/titanium" --size 80x32 "${small[@]}"
table "Soap bubbles" chart convergence scenes/bubbles.dae -o "$out/bubbles" --size 72x48 "${small[@]}"
table "Oil" chart convergence scenes/oil.dae -o "$out/oil" --size 72x48 "${small[@]}"
table "Christmas balls" chart convergence scenes/christmas_balls.dae -o "$out/christmas_balls" --size 72x48 "${small[@]}"
table "Coated glass" chart convergence scenes/coated_glass.dae -o "$out/coated_glass" --size 80x40 "${small[@]}"
table "Gold knot" chart convergence scenes/gold_knot.zae -o "$out/gold_knot" --size 60x60 "${small[@]}"
table "Facing films" chart convergence scenes/facing_films.dae -o "$out/facing_films" --size 72x48 "${small[@]}"

# RGB against spectral, on the same samples, as an error map.
for scene in facing_films bubbles titanium; do
    echo "comparing $scene" >&2
    for mode in rgb spectral; do
        options=("scenes/$scene.dae" --mode "$mode" --size 200x --quiet)
        "$pellicle" render "${options[@]}" --spp 64 -o "$cache/$mode.exr"
        "$pellicle" render "${options[@]}" --spp 64 -o "$out/$scene-$mode.png"
    done
    auto=$("$pellicle" render "scenes/$scene.dae" -o "$cache/auto.exr" --size 48x --spp 1 2>&1 | grep '^mode:')
    {
        printf '\n## RGB against spectral: %s\n\n`--mode auto` says: %s\n\n```\n' "$scene" "$auto"
        "$pellicle" compare "$cache/rgb.exr" "$cache/spectral.exr" --diff "$out/$scene-error.png" | grep -v z-test
        echo '```'
    } >>"$tables"
done
