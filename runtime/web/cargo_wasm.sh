#!/bin/sh
# Runs cargo for wasm32-unknown-unknown: `runtime/web/cargo_wasm.sh build -p pelage-web --profile web`. The output is in
# target/wasm.
#
# The target's standard library comes from rustup. If rustup cannot fetch it, it is compiled from Debian's source
# packages, which are installed if possible. Without either, prints an error and exits with 4.
set -eu
cd "$(dirname "$0")/../.."
target=wasm32-unknown-unknown
# A separate target folder: artifacts of two compilers cannot be mixed.
export CARGO_TARGET_DIR=target/wasm

has_std() { [ -d "$(rustc --print sysroot)/lib/rustlib/$target/lib" ]; }

debian_compiler() { dpkg -L rustc-web 2>/dev/null | grep -E '/bin/rustc$' | head -n 1; }

# Prints the major LLVM version of Debian's compiler, which is part of the linker's name.
llvm() { "$(debian_compiler)" -vV | sed -n 's/^LLVM version: \([0-9]*\).*/\1/p'; }

has_debian() {
    compiler=$(debian_compiler)
    # Compiler and sources must have the same version, which is part of their folder's name on Debian.
    [ -n "$compiler" ] && [ -d "$("$compiler" --print sysroot)/lib/rustlib/src/rust/library" ] &&
        command -v "lld-$(llvm)" >/dev/null 2>&1
}

apt_install() { DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends "$@" >&2; }

if ! has_std && command -v rustup >/dev/null 2>&1; then
    timeout 60 rustup target add "$target" >&2 || true
fi
if has_std; then
    exec cargo "$@" --target "$target" --locked
fi
if ! has_debian && command -v apt-get >/dev/null 2>&1 && [ "$(id -u)" = 0 ]; then
    apt-get update >&2 || true
    if apt_install rustc-web rust-web-src; then apt_install "lld-$(llvm)" || true; fi
fi
if has_debian; then
    RUSTC=$(debian_compiler) RUSTC_BOOTSTRAP=1 exec cargo "$@" --target "$target" -Zbuild-std=std,panic_abort
fi
echo "missing: Rust's standard library for $target (rustup target add $target;" \
    "Debian: apt-get install rustc-web rust-web-src, and the lld of the same LLVM version)" >&2
exit 4
