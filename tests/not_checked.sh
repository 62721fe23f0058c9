#!/bin/sh
# Says that the gate could not make a check: `tests/not_checked.sh NAME WORDS`. Elsewhere that is a line to read; where CI is set it is a
# failure, unless PELAGE_EXCEPTIONS (names with spaces between) has the name. Names go to the file PELAGE_NOT_CHECKED, too.
set -eu
name=$1 words=$2
echo "NOT CHECKED: $name: $words" >&2
[ -z "${PELAGE_NOT_CHECKED:-}" ] || echo "$name" >>"$PELAGE_NOT_CHECKED"
case "${CI:-}" in "" | 0 | false) exit 0 ;; esac
case " ${PELAGE_EXCEPTIONS:-} " in
*" $name "*) echo "EXCEPTION: $name may go unchecked here, by PELAGE_EXCEPTIONS" >&2 ;;
*)
    echo "CI is set: $name must be checked, or be named in PELAGE_EXCEPTIONS" >&2
    exit 1
    ;;
esac
