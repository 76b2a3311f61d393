#!/usr/bin/env bash
# Runs targets of the Makefile two at a time, all of them, and names at the end those that failed:
#   MAKE=... config/two_at_a_time.sh TARGET...
set -euo pipefail

failed=$(mktemp)
trap 'rm -f "$failed"' EXIT
printf '%s\n' "$@" | xargs --max-procs 2 -I TARGET bash -c "$MAKE TARGET || echo TARGET >>'$failed'"
if [[ -s $failed ]]; then
  echo "failed: $(sort "$failed" | xargs)" >&2
  exit 1
fi
