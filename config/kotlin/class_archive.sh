#!/usr/bin/env bash
# Writes ARCHIVE, from which the simulated headset's Java takes loaded classes: a start needs a fifth less processor
# time. Java ignores the archive once a jar is newer. A session of one second loads the classes.
#   config/kotlin/class_archive.sh ARCHIVE
set -euo pipefail
# shellcheck source=/dev/null
source "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/../errors.sh"
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

folder=$(mktemp --directory)
receiver=
trap 'kill $receiver 2>"$folder/ended" || [[ -z $receiver ]]; wait; rm -rf "$folder"' EXIT
cat >"$folder/config.yaml" <<'END'
/ml2_receiver:
  ros__parameters:
    world_left: {enabled: true}
    depth_center: {enabled: true}
END
mkfifo "$folder/said"
host_receiver/ml2-receiver record "$folder/walk" --no-ros --insecure --listen 127.0.0.1:0 \
  --config "$folder/config.yaml" >"$folder/said" &
receiver=$!
address=
while [[ -z $address ]] && read -r line; do
  address=$(sed -n 's/.*listening on \([0-9.:]*\).*/\1/p' <<<"$line")
done <"$folder/said"
rm -f "$1"
JDK_JAVA_OPTIONS="-XX:ArchiveClassesAtExit=$folder/archive -Xlog:cds=off -Xlog:cds+dynamic=off" \
  ml2-sensors-aar/simulator/ml2-headset --receiver "$address" --insecure --duration 1 --simulate still_images=1
mv "$folder/archive" "$1"
