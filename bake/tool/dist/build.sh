#!/bin/sh
# Makes the release files from one release build: `bake/tool/dist/build.sh FOLDER`. On Linux: a wheel, an archive, a
# Debian package, and the npm package of the page; elsewhere: a wheel and an archive. The build needs cargo and
# Python 3. Binaries for Linux are linked against glibc 2.28, so that they run on distributions from 2019 on.
set -eu
cd "$(dirname "$0")/../../.."
mkdir -p "$1"
out=$(cd "$1" && pwd)
glibc=2.28
# Tested versions.
tools="maturin==1.16.0 ziglang==0.17.1"

version=$(sed -n '/^\[workspace.package\]/,/^\[/s/^version = "\(.*\)"/\1/p' Cargo.toml)
host=$(rustc -vV | sed -n 's/^host: //p')
system=$(uname -s)

# The tools have their own folder, so that nothing is installed on the system.
tools_folder=$out/tools
if [ "$(cat "$tools_folder/made_of" 2>/dev/null || true)" != "$tools" ]; then
    rm -rf "$tools_folder"
    python3 -m venv "$tools_folder"
    bin=bin
    [ -d "$tools_folder/bin" ] || bin=Scripts
    # shellcheck disable=SC2086 # a list of packages
    "$tools_folder/$bin/python" -m pip install --quiet --disable-pip-version-check $tools
    echo "$tools" >"$tools_folder/made_of"
fi
bin=$tools_folder/bin
[ -d "$bin" ] || bin=$tools_folder/Scripts
PATH=$bin:$PATH

rm -rf "$out"/pelage-* "$out"/pelage_* "$out/npm"
set -- --locked --out "$out" --target "$host"
if [ "$system" = Linux ]; then
    set -- "$@" --zig --compatibility "manylinux_$(echo $glibc | tr . _)"
fi
(cd bake/tool/dist && maturin build "$@")
ending=""
case "$host" in *windows*) ending=.exe ;; esac
built=target/$host/packaged/pelage$ending

if [ "$system" = Linux ]; then
    newest=$(objdump -T "$built" | grep -o 'GLIBC_[0-9.]*' | sort -Vu | tail -n 1)
    if [ "$(printf '%s\n' "GLIBC_$glibc" "$newest" | sort -V | tail -n 1)" != "GLIBC_$glibc" ]; then
        echo "the binary requires $newest, expected at most GLIBC_$glibc" >&2
        exit 1
    fi
fi

# The installed tree, for /usr or for the folder where the archive is unpacked.
name=pelage-$version-$host
tree=$out/$name
mkdir -p "$tree/bin" "$tree/share/doc/pelage"
cp "$built" "$tree/bin/"
"$tree/bin/pelage$ending" manual "$tree/share" -q
cp bake/tool/dist/README.md LICENSE-MIT LICENSE-APACHE "$tree/share/doc/pelage/"
set --
if tar --version | grep -q GNU; then set -- --sort=name --owner=0 --group=0 --numeric-owner; fi
tar -C "$out" -czf "$out/$name.tar.gz" "$@" "$name"

if command -v dpkg-deb >/dev/null; then
    deb=$out/deb
    rm -rf "$deb"
    mkdir -p "$deb/DEBIAN"
    cp -r "$tree" "$deb/usr"
    find "$deb/usr/share/man" -name '*.1' -exec gzip -9n {} +
    cat >"$deb/DEBIAN/control" <<CONTROL
Package: pelage
Version: $version
Architecture: $(dpkg --print-architecture)
Maintainer: the authors of pelage <noreply@example.org>
Depends: libc6 (>= $glibc)
Recommends: libvulkan1, mesa-vulkan-drivers, libxkbcommon-x11-0, libxcursor1, libxi6, libxrandr2
Section: graphics
Priority: optional
Description: fur, hair and ink-wash painting for glTF characters
 The command pelage bakes a glTF or OBJ model into a package with its fur and
 draws it in pictures and in a window.
CONTROL
    dpkg-deb --root-owner-group --build "$deb" "$out/pelage_${version}_$(dpkg --print-architecture).deb" >/dev/null
    rm -rf "$deb"
fi
rm -rf "$tree"

if [ "$system" = Linux ]; then
    status=0
    web=$PWD/target/web/npm
    runtime/web/build.sh target/web || status=$?
    case $status in
    0) (cd "$out" && npm pack --silent "$web" >/dev/null) ;;
    4) echo "the npm package is left out: the tools named above are missing" >&2 ;;
    *) exit 1 ;;
    esac
fi
(cd "$out" && ls -l pelage*)
