#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Stands before `lfz` in the suite: notes how it is called, and passes everything on, except for what takes long:
# `run` waits for its end, and `west` only speaks. A `graph` that this `lfz` does not know yet is a small picture.
echo "$*" >>"$LF_EDITOR_CALLS"
case "$1" in
  run)
    case "$*" in *--without*) exec "$LF_EDITOR_LFZ" "$@" ;; esac
    trap 'echo "ended" >>"$LF_EDITOR_CALLS"; exit 130' HUP INT TERM
    echo "the program runs"
    while :; do sleep 1 & wait $!; done
    ;;
  west) echo "an image is built" ;;
  graph)
    if "$LF_EDITOR_LFZ" graph --help >/dev/null 2>&1; then exec "$LF_EDITOR_LFZ" "$@"; fi
    echo '<svg xmlns="http://www.w3.org/2000/svg" width="320" height="80"><text x="9" y="40">'"$2"'</text></svg>'
    ;;
  *) exec "$LF_EDITOR_LFZ" "$@" ;;
esac
