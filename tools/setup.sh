#!/usr/bin/env bash
# Installs what a build needs on Debian 12, as root or as a user with sudo. Safe to run again: does nothing when done.
set -euo pipefail
packages=(
    g++ python3 xz-utils clang clang-tidy clang-format cmake ninja-build ccache mold pkg-config git ca-certificates
    libdraco-dev libboost-dev libssl-dev libzstd-dev zstd libgtest-dev libgmock-dev libbenchmark-dev
    libcli11-dev libfmt-dev libspdlog-dev nlohmann-json3-dev libembree-dev libhwy-dev libxxhash-dev libeigen3-dev
    libzip-dev libexpat1-dev libtinyobjloader-dev libtinygltf-dev libmeshoptimizer-dev libtbb-dev libclang-rt-14-dev
    nginx-light varnish haproxy  # started by tests of server/deploy
    libepoxy-dev libegl-dev libgl-dev libgl1-mesa-dri libstb-dev libwebp-dev
    libglfw3-dev libimgui-dev xvfb xauth
    emscripten esbuild zopfli chromium fonts-dejavu-core
)
# Node may be there from elsewhere, with npm inside it.
command -v npm >/dev/null || packages+=(nodejs npm)
missing=()
for package in "${packages[@]}"; do
    dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q 'install ok installed' || missing+=("$package")
done
[ ${#missing[@]} -gt 0 ] || exit 0

root=()
if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || { echo "setup.sh: run this as root, or install sudo: ${missing[*]} missing" >&2; exit 1; }
    root=(sudo)
fi
# Some machines hold package locks for a moment after they start: wait for them.
apt=("${root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=300)
"${apt[@]}" update
# --no-remove: rather fail than take other software off the machine to make room for ours.
"${apt[@]}" install -y --no-install-recommends --no-remove "${missing[@]}"
