#!/usr/bin/env bash
# Builds the WebAssembly module, the npm package and the page: one command, into FOLDER (default: build).
#
#   client/web/build.sh [FOLDER]
#
# FOLDER/web/mvw is the package (npm pack does there), FOLDER/page what `mvw serve` beside it offers at /. Draco's and
# zstd's decoders come from Debian's source packages, fetched once into FOLDER/web/sources.
set -euo pipefail
here="$(cd "$(dirname "$0")" && pwd)"
build="$(realpath -m "${1:-$here/../../build}")"
out="$build/web" page="$build/page"
mkdir -p "$out/sources" "$out/module"

# Debian's own package lists may lack the sources: asks the same mirrors with lists of its own.
fetch_sources() {
    local work="$out/sources/fetch"
    rm -rf "$work"
    mkdir -p "$work/parts" "$work/lists/partial" "$work/cache/archives/partial"
    for list in /etc/apt/sources.list /etc/apt/sources.list.d/*.list; do
        [ ! -s "$list" ] || sed -n 's/^deb /deb-src /p' "$list" >"$work/parts/$(basename "$list" .list).list"
    done
    for list in /etc/apt/sources.list.d/*.sources; do
        [ ! -s "$list" ] || sed 's/^Types:.*/Types: deb-src/' "$list" >"$work/parts/$(basename "$list")"
    done
    local apt=(-q -o Dir::Etc::SourceList=/dev/null -o Dir::Etc::SourceParts="$work/parts"
        -o Dir::State::Lists="$work/lists" -o Dir::Cache="$work/cache" -o APT::Sandbox::User="$(id -un)")
    apt-get "${apt[@]}" update >&2
    download_source draco
    download_source libzstd
    mkdir -p "$out/sources/draco" "$out/sources/zstd"
    tar -xJf "$work"/draco_*.orig.tar.xz -C "$out/sources/draco" --strip-components=1 --wildcards '*/src/draco/*'
    tar -xJf "$work"/libzstd_*.orig.tar.xz -C "$out/sources/zstd" --strip-components=1 --wildcards '*/lib/*'
    rm -rf "$work"
    trim_draco "$out/sources/draco/src/draco/compression"
    touch "$out/sources/trimmed"
}

# The newest version that the mirrors have: one may list an update that it has not got, yet or any more.
download_source() {
    local version
    for version in $(apt-cache "${apt[@]}" showsrc --only-source "$1" | sed -n 's/^Version: //p' | sort -ruV); do
        (cd "$work" && apt-get "${apt[@]}" --download-only source "$1=$version" >&2) && return
    done
    echo "build.sh: no mirror in /etc/apt has the source of $1; try again later" >&2
    return 1
}

# What integer positions without metadata (FORMAT.md 4.1) never need; without it the module is smaller.
trim_draco() {
    sed -i '/else if (method == MESH_PREDICTION_TEX_COORDS_PORTABLE) {/,/^      }$/d' \
        "$1/attributes/prediction_schemes/prediction_scheme_decoder_factory.h"
    sed -i '/case SEQUENTIAL_ATTRIBUTE_ENCODER_\(GENERIC\|QUANTIZATION\):/,/AttributeDecoder());/d' \
        "$1/attributes/sequential_attribute_decoders_controller.cc"
    sed -i '/if (GetDecoder()->options()) {/,/^    }$/d' "$1/attributes/sequential_attribute_decoders_controller.cc"
    sed -i 's/DRACO_RETURN_IF_ERROR(DecodeMetadata())/return Status(Status::UNSUPPORTED_FEATURE, "metadata");/' \
        "$1/point_cloud/point_cloud_decoder.cc"
    # Nor has a mesh of one attribute seams.
    sed -i '/if (att_ct != nullptr) {/,/^    } else {$/c\    if (att_ct == nullptr) {' \
        "$1/attributes/prediction_schemes/prediction_scheme_factory.h"
    sed -i '/^    \/\/ Per-corner attribute decoder\.$/,/^    sequencer = std::move(traversal_sequencer);$/c\    return false;' \
        "$1/mesh/mesh_edgebreaker_decoder_impl.cc"
}

for program in em++ esbuild zopfli; do
    command -v "$program" >/dev/null || { echo "build.sh: $program is missing (tools/setup.sh installs it)" >&2; exit 1; }
done
[ -e "$out/sources/trimmed" ] || fetch_sources

launcher=()
if command -v ccache >/dev/null; then
    launcher=(-DCMAKE_C_COMPILER_LAUNCHER=ccache -DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
fi
if [ ! -e "$out/module/build.ninja" ]; then
    emcmake cmake -G Ninja -S "$here/wasm" -B "$out/module" -DCMAKE_BUILD_TYPE= "${launcher[@]}" \
        -DDRACO_SOURCE="$out/sources/draco" -DZSTD_SOURCE="$out/sources/zstd" >/dev/null
fi
cmake --build "$out/module" > "$out/module/build.log" || { cat "$out/module/build.log" >&2; exit 1; }
tail -n 1 "$out/module/build.log"
# What the linker's pass leaves shrinks by another hundredth when passes go on until none helps, and by as much again
# when control flow is built anew.
wasm-opt -Oz --converge --flatten --rereloop -Oz -Oz --low-memory-unused --enable-simd --enable-bulk-memory --enable-sign-ext \
    --enable-mutable-globals --enable-nontrapping-float-to-int "$out/module/mvw.wasm" -o "$out/module/packed.wasm"

mkdir -p "$out/mvw/src" "$page"
find "$out/mvw/src" "$page" -mindepth 1 -delete  # the folders stay: a running server holds them
cp "$here"/package.json "$here"/README.md "$out/mvw/"
cp "$here"/src/* "$out/mvw/src/"
cp "$here"/page/*.svg "$page/"
cp "$out/module/packed.wasm" "$out/mvw/src/mvw.wasm"
cp "$out/module/packed.wasm" "$page/mvw.wasm"
# The page's scripts in three files: its own, the worker's, and what measures both.
rm -rf "$out/scripts" && mkdir "$out/scripts"
cp "$here"/src/*.js "$here"/page/*.js "$out/scripts/"
bundle=(esbuild --minify --target=es2022 --log-level=warning)
"${bundle[@]}" --bundle --format=esm --external:./work.js --outdir="$page" "$out/scripts/page.js" "$out/scripts/worker.js"
"${bundle[@]}" --outfile="$page/work.js" "$out/scripts/work.js"
"${bundle[@]}" --outfile="$page/page.css" "$here/page/page.css"
sed -E 's/^\s+//' "$here/page/index.html" >"$page/index.html"

# Packed once, here: mvw serve sends these to whoever accepts them.
for file in "$page"/*; do
    zopfli -c "$file" >"$file.gz"
done
node - "$page" <<'END'
const { readdirSync, readFileSync, writeFileSync } = require('node:fs');
const { brotliCompressSync, constants } = require('node:zlib');
const folder = process.argv[2];
const names = readdirSync(folder).filter((name) => !name.endsWith('.gz'));
// What packs the module best of all that were tried.
const params = {
  [constants.BROTLI_PARAM_LGWIN]: 19,
  [constants.BROTLI_PARAM_LGBLOCK]: 19,
  [constants.BROTLI_PARAM_NPOSTFIX]: 1,
  [constants.BROTLI_PARAM_NDIRECT]: 8,
};
for (const name of names) writeFileSync(`${folder}/${name}.br`, brotliCompressSync(readFileSync(`${folder}/${name}`), { params }));
for (const [coding, ending] of [['brotli', '.br'], ['gzip', '.gz']]) {
  const bytes = (name) => readFileSync(`${folder}/${name}${ending}`).length;
  console.log(`page: ${names.reduce((sum, name) => sum + bytes(name), 0)} bytes in ${coding}, ${bytes('mvw.wasm')} of them the module`);
}
END
