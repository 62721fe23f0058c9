#!/bin/sh
# Installs each file of build.sh in isolation, then bakes and draws the hare with it: `bake/tool/dist/check.sh FOLDER`.
set -eu
cd "$(dirname "$0")/../../.."
dist=$(cd "$1" && pwd)
hare=$PWD/assets/models/hare.glb
empty=$(mktemp -d)
trap 'rm -rf "$empty"' EXIT

# draws PELAGE NAME: bakes and draws the hare in an empty folder.
draws() {
    mkdir "$empty/$2"
    (
        cd "$empty/$2"
        cp "$hare" hare.glb
        "$1" bake hare.glb -o hare.pelage -q
        "$1" render hare.pelage -o hare.png -q
        [ "$(head -c 4 hare.png | tail -c 3)" = PNG ]
        [ "$(find . -type f | sort | tr '\n' ' ')" = "./hare.glb ./hare.pelage ./hare.png " ]
    )
    echo "$2: the hare is baked and drawn"
}

mkdir "$empty/unpacked"
tar -C "$empty/unpacked" -xzf "$dist"/pelage-*.tar.gz
[ -s "$(echo "$empty"/unpacked/*/share/man/man1/pelage-bake.1)" ]
draws "$(echo "$empty"/unpacked/*/bin/pelage)" archive

if command -v dpkg-deb >/dev/null; then
    dpkg-deb -x "$dist"/pelage_*.deb "$empty/debian"
    [ -s "$empty/debian/usr/share/bash-completion/completions/pelage" ]
    draws "$empty/debian/usr/bin/pelage" deb
fi

python3 -m venv "$empty/venv"
"$empty/venv/bin/pip" install --quiet --disable-pip-version-check --no-index "$dist"/pelage-*.whl
draws "$empty/venv/bin/pelage" wheel

if command -v npm >/dev/null; then
    mkdir "$empty/page"
    (cd "$empty/page" && npm init -y >/dev/null && npm install --silent --offline "$dist"/pelage-*.tgz)
    [ -s "$empty"/page/node_modules/pelage/pelage_web_bg.wasm ]
    echo "npm: the package is installed"
fi
