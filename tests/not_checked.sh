#!/bin/sh
# Reports that the gate could not run a check: `tests/not_checked.sh NAME REASON`. Prints a warning. If CI is set, also
# fails, unless PELAGE_EXCEPTIONS (names separated by spaces) contains NAME. Appends NAME to the file
# PELAGE_NOT_CHECKED, if set.
set -eu
name=$1 words=$2
echo "NOT CHECKED: $name: $words" >&2
[ -z "${PELAGE_NOT_CHECKED:-}" ] || echo "$name" >>"$PELAGE_NOT_CHECKED"
case "${CI:-}" in "" | 0 | false) exit 0 ;; esac
case " ${PELAGE_EXCEPTIONS:-} " in
*" $name "*) echo "EXCEPTION: $name is allowed to be unchecked by PELAGE_EXCEPTIONS" >&2 ;;
*)
    echo "CI is set: $name must be checked, or listed in PELAGE_EXCEPTIONS" >&2
    exit 1
    ;;
esac
