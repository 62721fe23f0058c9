#!/bin/sh
# Builds the npm package and the page: `runtime/web/build.sh FOLDER [PROFILE]`. FOLDER/npm is what `npm pack` takes, FOLDER/site what a server serves;
# the profile is `web`, for what people load, unless another one is named. Exits with 4 where a tool is missing.
set -eu
cd "$(dirname "$0")/../.."
out=$1 profile=${2:-web}

runtime/web/cargo_wasm.sh build -p pelage-web --profile "$profile"
# The folder is not where that build's crates lie: they are of another compiler.
cargo run --quiet --locked --manifest-path runtime/web/binder/Cargo.toml --target-dir target/binder -- \
    "target/wasm/wasm32-unknown-unknown/$profile/pelage_web.wasm" "$out/bound"

rm -rf "$out/npm" "$out/site/pelage"
mkdir -p "$out/npm" "$out/site"
cp runtime/web/npm/* LICENSE-MIT LICENSE-APACHE "$out/npm/"
cp "$out/bound/pelage_web_bg.wasm" "$out/npm/"
# Its comments are those of index.d.ts in other words, and nobody reads how it is indented.
sed -e "/^ *\/\*\*/,/\*\//d" -e "s/^ *//" -e "/^\/\//d" -e "/^$/d" "$out/bound/pelage_web.js" >"$out/npm/pelage_web.js"
cp runtime/web/page/* "$out/site/"
cp -r "$out/npm" "$out/site/pelage"
