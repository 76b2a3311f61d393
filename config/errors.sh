# shellcheck shell=bash
# Sourced by the scripts: one that ends early says which command failed, where, and how.
set -o errtrace
unset CDPATH # with it, `cd` may go to a folder elsewhere that has the name of one here
# shellcheck disable=SC2154
trap 'status=$?; echo "${BASH_SOURCE[0]##*/}:$LINENO: exit code $status of: $BASH_COMMAND" >&2' ERR
