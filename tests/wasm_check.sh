#!/bin/sh
# Type-checks the runtime for wasm32-unknown-unknown. The target's standard library comes from rustup; where that cannot fetch it,
# from Debian's source packages (as root), built on the fly; else the check is not made, and says so.
set -eu
cd "$(dirname "$0")/.."
target=wasm32-unknown-unknown

has_std() { [ -d "$(rustc --print sysroot)/lib/rustlib/$target/lib" ]; }

check() { cargo check -p pelage-runtime --target "$target" --locked; }

if ! has_std && command -v rustup >/dev/null 2>&1; then
    rustup target add "$target" >&2 || true
fi
if has_std; then
    check
    exit
fi

if command -v apt-get >/dev/null 2>&1 && [ "$(id -u)" = 0 ]; then
    apt-get update >&2 || true
    if DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends rustc-web rust-web-src >&2; then
        # The compiler and the source must be of one version; Debian names their folder by it.
        compiler=$(dpkg -L rustc-web | grep -E '/bin/rustc$' | head -n 1)
        if [ -n "$compiler" ] && [ -d "$("$compiler" --print sysroot)/lib/rustlib/src/rust/library" ]; then
            # A target folder of its own: artifacts of two compilers do not mix.
            RUSTC=$compiler RUSTC_BOOTSTRAP=1 CARGO_TARGET_DIR=target/wasm-check \
                cargo check -p pelage-runtime --target "$target" -Zbuild-std=std,panic_abort
            exit
        fi
    fi
fi

exec tests/not_checked.sh wasm "rustup cannot add the target (rustup target add $target), and Debian's source packages are not there"
