#!/usr/bin/env bash
# Makes everything in docs/report: the figures of docs/report.md, the numbers below them, and the turntable.
#
#     docs/make_report.sh [PELLICLE]     default: target/release/pellicle
#
# SIZE (360 pixels), SPP (96) and FRAMES (24) may be set. Takes some ten minutes on two cores; wants ffmpeg for the video and JPEGs.
set -euo pipefail
cd "$(dirname "$0")/.."
pellicle=$(realpath "${1:-target/release/pellicle}")
out=docs/report
mkdir -p "$out"
cache=$(mktemp -d)
trap 'rm -rf "$cache"' EXIT
size=${SIZE:-360} spp=${SPP:-96} frames=${FRAMES:-24}

# The same samples with each model: the 2020 report's, ours in RGB, and the exact one per wavelength.
for scene in dragon transparent; do
    last=$([ $scene = dragon ] && echo 3 || echo 1)
    for model in three-wave rgb exact; do
        case $model in
            three-wave) options=(--mode rgb --film three-wave) ;;
            rgb) options=(--mode rgb) ;;
            exact) options=(--mode spectral) ;;
        esac
        echo "rendering $scene, $model" >&2
        "$pellicle" animate "scenes/report/$scene.zae" -o "$cache/$scene-$model.####.exr" --frames "0-$last" \
            --size "${size}x" --spp "$spp" --seed-lock --quiet --report "$cache/$scene-$model" "${options[@]}"
    done
done

jpeg() { # picture, smaller picture
    ffmpeg -v error -y -i "$1" -frames:v 1 -q:v 2 "$2"
}

figure() { # scene, frame, name
    local number exact error
    number=$(printf %04d "$2")
    exact=$cache/$1-exact.$number.exr
    for model in three-wave rgb; do
        error=$("$pellicle" compare "$cache/$1-$model.$number.exr" "$exact" --diff "$cache/error-$model.png" | grep ^CIEDE2000)
        echo "| $3 | $model | $(sed 's/CIEDE2000 *mean //; s/, 99 % within / | /; s/, worst / | /' <<<"$error") |" >>"$out/tables.md"
    done
    jpeg "$cache/error-three-wave.png" "$out/$3-error.jpg"
    for model in three-wave exact; do
        # A video of one frame is a picture.
        mkdir -p "$cache/one" && cp "$cache/$1-$model.$number.exr" "$cache/one/f.0000.exr"
        "$pellicle" encode "$cache/one" -o "$cache/one.png" --exposure 0.6 --quiet
        jpeg "$cache/one.png" "$out/$3-$model.jpg"
    done
}

printf '# Numbers of the report\n\nWritten by `docs/make_report.sh`: CIEDE2000 of whole pictures, %sx%s, %s samples per pixel, against\n' \
    "$size" "$size" "$spp" >"$out/tables.md"
printf 'wavelengths along the same pixels. The noise of both pictures is in it: `rgb` shows how much that is.\n\n' >>"$out/tables.md"
printf '| figure | model | mean | 99 %% within | worst |\n|---|---|---|---|---|\n' >>"$out/tables.md"
figure dragon 0 dragon-550nm
figure dragon 1 dragon-550nm-even
figure dragon 2 dragon-250nm
figure dragon 3 dragon-750nm
figure transparent 0 transparent
figure transparent 1 transparent-even

echo "rendering the turntable" >&2
"$pellicle" turntable scenes/report/dragon.zae -o "$cache/turn.####.png" --frames "$frames" --mode object --size 240x \
    --spp $((spp / 2)) --quiet --report "$cache/turn" --video "$out/turntable.mp4"
# Every other frame of it, as a picture.
ffmpeg -v error -y -i "$out/turntable.mp4" -vf "select=not(mod(n\,2)),scale=200:200,tile=6x2" -frames:v 1 -q:v 3 "$out/turntable.jpg"
