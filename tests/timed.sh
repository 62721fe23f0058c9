#!/bin/sh
# Runs a test binary and prints the duration of each test: cargo's runner for the tests of the gate. Stable test
# harnesses accept the flag if RUSTC_BOOTSTRAP is set; nothing is compiled with that variable. Programs that are not
# test harnesses, or reject the flag, run unchanged.
set -eu
program=$1
shift
case "$program" in
*/deps/*)
    if RUSTC_BOOTSTRAP=1 "$program" --list -Z unstable-options --report-time >/dev/null 2>&1; then
        RUSTC_BOOTSTRAP=1 exec "$program" "$@" -Z unstable-options --report-time
    fi
    ;;
esac
exec "$program" "$@"
