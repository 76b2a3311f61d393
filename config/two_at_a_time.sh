#!/usr/bin/env bash
# Runs targets of the Makefile two at a time, all of them, each line of output with its target, and
# names at the end those that failed:
#   MAKE=... config/two_at_a_time.sh TARGET...
set -euo pipefail

failed=$(mktemp)
trap 'rm -f "$failed"' EXIT
export MAKE failed
# shellcheck disable=SC2016
printf '%s\n' "$@" | xargs --max-procs 2 -I TARGET bash -c \
  'set -o pipefail; $MAKE "$0" 2>&1 | sed --unbuffered "s/^/$0 | /" || echo "$0" >>"$failed"' TARGET
if [[ -s $failed ]]; then
  echo "failed: $(sort "$failed" | xargs)" >&2
  exit 1
fi
