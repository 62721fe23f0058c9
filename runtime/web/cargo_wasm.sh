#!/bin/sh
# Cargo for wasm32-unknown-unknown: `runtime/web/cargo_wasm.sh build -p pelage-web --profile web`. What it builds lies in target/wasm.
#
# The target's standard library comes from rustup; where that cannot fetch it, from Debian's source packages (installed where it may), built on the fly.
# Where there is neither it says so and exits with 4.
set -eu
cd "$(dirname "$0")/../.."
target=wasm32-unknown-unknown
# A target folder of its own: artifacts of two compilers do not mix.
export CARGO_TARGET_DIR=target/wasm

has_std() { [ -d "$(rustc --print sysroot)/lib/rustlib/$target/lib" ]; }

debian_compiler() { dpkg -L rustc-web 2>/dev/null | grep -E '/bin/rustc$' | head -n 1; }

# The major version of LLVM that Debian's compiler is of; its linker has it in the name.
llvm() { "$(debian_compiler)" -vV | sed -n 's/^LLVM version: \([0-9]*\).*/\1/p'; }

has_debian() {
    compiler=$(debian_compiler)
    # The compiler and the source must be of one version; Debian names their folder by it.
    [ -n "$compiler" ] && [ -d "$("$compiler" --print sysroot)/lib/rustlib/src/rust/library" ] && command -v "lld-$(llvm)" >/dev/null 2>&1
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
echo "missing: Rust's standard library for $target (rustup target add $target; Debian: apt-get install rustc-web rust-web-src, and lld of its LLVM)" >&2
exit 4
