#!/usr/bin/env bash
# Makes what fuzzing starts from: corpus/TARGET/ and words.dict, out of the scenes and test files of this repository.
set -euo pipefail
cd "$(dirname "$0")"

# Mutations of large files are mostly noise between numbers.
small() { find "$@" -type f -size -24k; }
seed() { # seed TARGET FILE...: each under its content's name
    local target=$1 file
    mkdir -p "corpus/$target"
    shift
    for file; do cp "$file" "corpus/$target/$(sha1sum "$file" | cut -c1-16)"; done
}

scenes=$(small ../scenes ../tests/data -name '*.dae')
for target in scene picture; do
    while IFS= read -r file; do seed "$target" "$file"; done <<<"$scenes"
done
seed archive $(small ../tests/data -name '*.zae')
for format in png exr hdr tif tga bmp jpg; do
    while IFS= read -r file; do seed image "$file"; seed frame "$file"; done < <(small ../tests ../scenes -name "*.$format")
done
seed medium $(small ../data/nk -name '*.csv')

# Pictures, parts and checkpoints of this program itself.
made=$(mktemp -d)
trap 'rm -r "$made"' EXIT
pellicle=../target/debug/pellicle
[ -x "$pellicle" ] || (cd .. && cargo build --locked)
room=../tests/data/cli/room.dae
for options in '' --float '--aov normal,depth,object' '--mode spectral'; do
    $pellicle render $room -q --size 12x9 --spp 1 $options -o "$made/a${options//[ ,]/}.exr"
done
$pellicle render $room -q --size 12x9 --spp 1 -o "$made/a.png"
$pellicle render $room -q --size 12x9 --spp 1 --png-depth 16 -o "$made/b.png"
seed frame "$made"/*.exr "$made"/*.png
seed image "$made"/*.exr "$made"/*.png
$pellicle render $room -q --size 12x9 --spp 4 --samples 0:2 -o "$made/a.part"
$pellicle render $room -q --size 40x30 --spp 4 --samples 2:4 -o "$made/b.part"
seed part "$made"/*.part
python3 - "$made" <<'PYTHON'
import os, struct, sys, zlib
# One small file of each format that the tests write only as they run.
folder = sys.argv[1]
def save(name, data):
    with open(os.path.join(folder, name), "wb") as file: file.write(data)
rgb = bytes(range(48))
save("a.tga", struct.pack("<BBBHHBHHHHBB", 0, 0, 2, 0, 0, 0, 0, 0, 4, 4, 24, 0) + rgb)
save("b.tga", struct.pack("<BBBHHBHHHHBB", 0, 0, 10, 0, 0, 0, 0, 0, 4, 4, 24, 0) + b"\x8f\x01\x02\x03")
save("a.bmp", b"BM" + struct.pack("<IHHI", 102, 0, 0, 54) + struct.pack("<IiiHHIIiiII", 40, 4, 4, 1, 24, 0, 48, 0, 0, 0, 0) + rgb)
save("a.hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 8\n" + bytes(range(64)))
tags = [(256, 3, 1, 4), (257, 3, 1, 4), (258, 3, 1, 8), (259, 3, 1, 1), (262, 3, 1, 1), (273, 4, 1, 8), (277, 3, 1, 1), (278, 3, 1, 4), (279, 4, 1, 16)]
save("a.tif", b"II*\0" + struct.pack("<I", 24) + bytes(range(16)) + struct.pack("<H", len(tags)) + b"".join(struct.pack("<HHII", *tag) for tag in tags) + bytes(4))
PYTHON
seed image "$made"/*.tga "$made"/*.bmp "$made"/*.hdr "$made"/*.tif

line=0
while IFS= read -r words; do
    line=$((line + 1))
    mkdir -p corpus/arguments corpus/words
    tr ' ' '\n' <<<"$words" >"corpus/arguments/$line"
    for word in $words; do printf %s "$word" >"corpus/words/$(sha1sum <<<"$word" | cut -c1-16)"; done
done < <(grep -rhoE '^ +pellicle [a-z].*' ../src/cli | sed -E 's/^ +pellicle //; s/"\)\]$//'; cat <<'WORDS'
render a.dae -o a.exr --size 320x200 --crop 1,2,30,40 --max-memory 8G --time 1m30s --noise 0.01 --clamp 10
animate a.dae -o f.%04d.png --frames 1,5,10-20x2 --fps 24 --shutter 180 --total-time 2h --resume
turntable a.dae -o f.####.exr --frames 0-9/120 --seed-lock
film --layer 1.33,250 --base 1.6+0.3i --angles 0:90:5 --illuminant blackbody:3200 --preset titanium:20
WORDS
)

# Names and values as they stand in the scenes.
grep -hoE '[A-Za-z_][A-Za-z_0-9]{2,20}' $scenes | sort | uniq -c | sort -rn | awk '$1 > 2 { print $2 }' | head -400 |
    sed -E 's/.*/"&"/' >words.dict
printf '%s\n' '"NaN"' '"INF"' '"-1"' '"4294967295"' '"1e39"' '"<![CDATA["' '"]]>"' '"<!--"' '"-->"' '"&#0;"' '"&amp;"' '"<!DOCTYPE"' '"/>"' '"#"' >>words.dict
du -sh corpus/* words.dict
