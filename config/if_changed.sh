#!/usr/bin/env bash
# Runs a command unless its inputs have the content that they had when it last succeeded:
#   config/if_changed.sh STAMP INPUT... -- COMMAND...
# An input is a file or a folder. STAMP keeps a hash of the inputs; its time is renewed, since make compares times.
set -euo pipefail
# shellcheck source=/dev/null
source "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/errors.sh"

stamp=$1
shift
inputs=()
while [[ $1 != -- ]]; do
  inputs+=("$1")
  shift
done
shift

hash_of_inputs() {
  find "${inputs[@]}" \( -name target -o -name node_modules -o -name '__pycache__' -o -name '.*_cache' -o -name '*.egg-info' \) \
    -prune -o -type f -print0 | sort -zu | xargs -0 sha256sum | sha256sum
}

content=$(hash_of_inputs)
if [[ $content == "$(cat "$stamp" 2>/dev/null)" ]]; then
  echo "$(basename "$stamp"): unchanged since it succeeded"
  touch "$stamp"
  exit
fi
rm -f "$stamp"
"$@" || { code=$?; echo "$(basename "$stamp"): exit code $code of: $*" >&2; exit $code; }
mkdir -p "$(dirname "$stamp")"
echo "$content" >"$stamp"
