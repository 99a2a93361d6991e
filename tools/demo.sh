#!/usr/bin/env bash
# The whole chain on a real scan: installs and builds what is missing, encodes the armadillo of Debian's CGAL package,
# serves it on a loopback port, streams it, and draws each refinement. Results stay in build/demo.
set -euo pipefail
cd "$(dirname "$0")/.."

say() { printf '\n== %s\n' "$*"; }
fail() { echo "demo.sh: $*" >&2; exit 1; }

say "Installing and building"
tools/setup.sh
cmake --preset default >/dev/null
cmake --build --preset default --target mvw
cmake --build --preset default --target web  # the page that the server offers

mvw="$PWD/build/mvw"
demo="$PWD/build/demo"
scan="$demo/armadillo.off"
mkdir -p "$demo/served"

if [ ! -s "$scan" ]; then
    say "Unpacking the armadillo scan from Debian's libcgal-demo"
    unpacked=$(mktemp -d)
    # apt downloads as a user of its own: the folder must let it in.
    chmod 755 "$unpacked"
    (cd "$unpacked" && apt-get -o APT::Sandbox::User="$(id -un)" download libcgal-demo && dpkg-deb -x libcgal-demo_*.deb files)
    for archive in "$unpacked"/files/usr/share/doc/libcgal-dev/*.tar.gz; do
        member=$(tar -tzf "$archive" | grep -m1 '/armadillo\.off$' || true)
        [ -z "$member" ] || { tar -xzf "$archive" -O "$member" >"$scan.part" && mv "$scan.part" "$scan"; }
    done
    rm -rf "$unpacked"
    [ -s "$scan" ] || fail "no armadillo.off in libcgal-demo"
fi

say "Encoding"
"$mvw" encode "$scan" "$demo/served/armadillo.mvw"
"$mvw" info "$demo/served/armadillo.mvw"

say "Serving and streaming"
"$mvw" serve "$demo/served" --tcp 127.0.0.1:0 --http 127.0.0.1:0 >"$demo/server.out" 2>"$demo/server.log" &
server=$!
trap 'kill "$server" 2>/dev/null || true' EXIT
url=
for _ in $(seq 100); do
    url=$(grep -o 'mvw://[^ ]*' "$demo/server.out" || true)
    [ -z "$url" ] || break
    kill -0 "$server" 2>/dev/null || fail "the server ended: $(cat "$demo/server.log")"
    sleep 0.1
done
[ -n "$url" ] || fail "the server does not start: $(cat "$demo/server.log")"
rm -rf "$demo/snapshots"
"$mvw" fetch "$url/armadillo" "$demo/streamed.ply" --snapshots "$demo/snapshots" | tee "$demo/table.txt"
kill "$server"
wait "$server" || true
trap - EXIT

say "Drawing"
view=(--size 800x800 --yaw 200)
for mesh in "$demo"/snapshots/*.ply; do
    "$mvw" view "$mesh" --screenshot "${mesh%.ply}.png" "${view[@]}"
done
for level in 0 1 2; do
    "$mvw" view "$demo/served/armadillo.mvw" --level "$level" --wireframe --screenshot "$demo/level$level.png" "${view[@]}"
done
"$mvw" view "$scan" --screenshot "$demo/scan.png" "${view[@]}"
# README's pictures, by their names: to renew them, copy this folder to tools/pictures.
mkdir -p "$demo/pictures"
small=(--size 480x480 --yaw 200)
for kilobytes in 2 7; do
    "$mvw" decode "$demo/served/armadillo.mvw" "$demo/prefix.ply" --max-bytes $((kilobytes * 1024))
    "$mvw" view "$demo/prefix.ply" --screenshot "$demo/pictures/armadillo_${kilobytes}_kb.png" "${small[@]}"
done
"$mvw" view "$demo/served/armadillo.mvw" --screenshot "$demo/pictures/armadillo_whole.png" "${small[@]}"
"$mvw" view "$scan" --screenshot "$demo/pictures/armadillo_scan.png" "${small[@]}"
"$mvw" view "$demo/served/armadillo.mvw" --animation "$demo/pictures/armadillo.webp" "${small[@]}"
"$mvw" compare "$scan" "$demo/streamed.ply"

cat <<END

Pictures of each refinement:         $demo/snapshots/*.png
of the coarse levels' triangles:     $demo/level*.png
and of the scan itself:              $demo/scan.png

README's pictures:                   $demo/pictures/*

To look further:
  $mvw info $demo/served/armadillo.mvw
  $mvw view $demo/served/armadillo.mvw                (a window; or --screenshot FILE.png)
  $mvw encode YOUR_MESH $demo/served/yours.mvw       (.ply .obj .stl .3mf .off .gltf .glb)
  $mvw fetch mvw://127.0.0.1:7707/yours yours.ply --max-bytes 10000
  $mvw serve $demo/served

and open  http://127.0.0.1:8080/  to see it refine in a browser.
END
if [ -t 0 ] && [ -t 1 ]; then
    printf '\nThe server runs now, at that address, until Ctrl-C.\n'
    exec "$mvw" serve "$demo/served"
fi
