#!/usr/bin/env bash
# Runs each fuzz target of the receiver for SECONDS; what is found interesting stays in build/fuzz, and is gone on from.
# Usage: run.sh SECONDS [TARGET]...
set -euo pipefail
# shellcheck source=/dev/null
source "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/../../config/errors.sh"
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

seconds=$1
shift
read -ra targets <<<"${*:-$(python3 tests/fuzz/fuzz.py | tr '\n' ' ')}"
for target in "${targets[@]}"; do
    folder=build/fuzz/$target
    log=$folder.log
    mkdir -p "$folder"
    touch "$log.began"
    echo "fuzzing $target for $seconds s"
    python3 tests/fuzz/fuzz.py "$target" "$folder" -max_total_time="$seconds" -max_len=8192 -timeout=10 \
        -rss_limit_mb=2048 -artifact_prefix="$folder-" -print_final_stats=1 &>"$log" || {
        tail -n 40 "$log" >&2
        found=$(find build/fuzz -name "$target-*" -newer "$log.began")
        echo "fuzz: $target fails for $found" >&2
        echo "      again: host_receiver/environment/run.sh python3 tests/fuzz/fuzz.py $target $found" >&2
        exit 1
    }
    grep -E 'stat::number_of_executed_units|DONE' "$log"
done
