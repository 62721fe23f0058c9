#!/bin/sh
# Builds the npm package and the page: `runtime/web/build.sh FOLDER [PROFILE]`. FOLDER/npm is the input of `npm pack`,
# and FOLDER/site the content for a web server. The default profile is `web`, for publication. Exits with 4 if a tool is
# missing.
set -eu
cd "$(dirname "$0")/../.."
out=$1 profile=${2:-web}

runtime/web/cargo_wasm.sh build -p pelage-web --profile "$profile"
echo "Generating the JavaScript bindings; the first time, their generator is compiled, which takes minutes." >&2
# A separate target folder, because the build for WebAssembly may use another compiler.
cargo run --quiet --locked --manifest-path runtime/web/binder/Cargo.toml --target-dir target/binder -- \
    "target/wasm/wasm32-unknown-unknown/$profile/pelage_web.wasm" "$out/bound" \
    "$(sed -n 's/.*"version": "\(.*\)".*/\1/p' runtime/web/npm/package.json)"

rm -rf "$out/npm" "$out/site/pelage"
mkdir -p "$out/npm" "$out/site"
cp runtime/web/npm/* LICENSE-MIT LICENSE-APACHE "$out/npm/"
cp "$out/bound/pelage_web_bg.wasm" "$out/npm/"
# Strips comments and indentation from the generated file; index.d.ts documents the API.
sed -e "/^ *\/\*\*/,/\*\//d" -e "s/^ *//" -e "/^\/\//d" -e "/^$/d" "$out/bound/pelage_web.js" >"$out/npm/pelage_web.js"
cp runtime/web/page/* "$out/site/"
cp -r "$out/npm" "$out/site/pelage"
