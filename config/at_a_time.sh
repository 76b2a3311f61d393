#!/usr/bin/env bash
# Runs targets of the Makefile, all of them, two at a time, or one on a machine with one processor. Each line
# of output has its target. At the end it repeats the last lines of those that failed, and names the tests and
# targets that failed:
#   MAKE=... config/at_a_time.sh TARGET...
set -euo pipefail
# shellcheck source=/dev/null
source "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/errors.sh"
shopt -s nullglob

logs=$(mktemp --directory)
trap 'rm -rf "$logs"' EXIT
export MAKE logs
# shellcheck disable=SC2016
printf '%s\n' "$@" | xargs --max-procs $(($(nproc) > 1 ? 2 : 1)) -I TARGET bash -c \
  'set -o pipefail
   TIMEFORMAT="%0R s; CPU %0U s, in the system %0S s"
   { time $MAKE "$0"; } 2>&1 | sed --unbuffered "s/^/$0 | /" | tee "$logs/$0" || mv "$logs/$0"{,.failed}' TARGET
failed=("$logs"/*.failed)
if ((${#failed[@]})); then
  printf '\n'
  tail --quiet --lines 60 "${failed[@]}"
  # As pytest, Surefire, CTest and NUnit write the name of a test that failed. Last, for a reader who sees only the end.
  grep --no-filename --extended-regexp \
    '\| (FAILED|ERROR) |<<< (FAILURE|ERROR)!|\*\*\*(Failed|Timeout|Exception)|\| [0-9]+\) (Failed|Error) :' \
    "${failed[@]}" | cut -c 1-300 | sort --unique | sed --quiet 1,30p >&2 || echo 'no test named itself' >&2
  # A full disk or a busy machine is told by no test.
  echo "$(df --human-readable --output=avail . | tail -1 | xargs) free on the disk, load average $(cut -d' ' -f1-3 /proc/loadavg)" >&2
  echo "failed: $(basename --multiple --suffix .failed "${failed[@]}" | xargs)" >&2
  exit 1
fi
