#!/bin/sh
# Runs a test binary so that it says how long each test took: cargo's runner for the tests of the gate. Stable test harnesses have
# the flag too, behind a word that unlocks it; nothing is compiled with that word. What is no test harness, or refuses, runs as it is.
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
