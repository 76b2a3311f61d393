#!/usr/bin/env bash
# Runs Maven. Its errors do not say that the disk is full: they name what could not be resolved.
set -euo pipefail
# shellcheck source=/dev/null
source "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/../errors.sh"

least_mb=100
mvn "$@" || {
  status=$?
  trap - ERR
  for folder in "$HOME" "$PWD"; do
    free_mb=$(df --block-size=M --output=avail "$folder" | tail -1 | tr -dc 0-9)
    if ((free_mb < least_mb)); then
      echo "maven: the disk of $folder has $free_mb MB free; make room, then try again" >&2
    fi
  done
  exit "$status"
}
