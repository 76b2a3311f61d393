#!/usr/bin/env bash
# Runs Gradle as gradle/wrapper/gradle-wrapper.properties names it, and downloads it first where it is missing:
#   ./gradlew :ml2-sensors-aar:assembleRelease
# Android Studio reads the same properties. It needs no gradle-wrapper.jar, and neither does this script.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)

property() {
  sed -n "s/^$1=//p" "$root/gradle/wrapper/gradle-wrapper.properties" | sed 's/\\//g'
}

url=$(property distributionUrl)
sum=$(property distributionSha256Sum)
folder=${GRADLE_USER_HOME:-$HOME/.gradle}/wrapper/dists/ml2-sensors/$sum

if [[ ! -e $folder/gradle ]]; then
  mkdir -p "$folder"
  part=$(mktemp -d "$folder/part.XXXXXX")
  trap 'rm -rf "$part"' EXIT
  echo "gradlew: downloading $url"
  curl --fail --location --progress-bar --output "$part/gradle.zip" "$url"
  found=$(sha256sum "$part/gradle.zip" | cut -d ' ' -f 1)
  if [[ $found != "$sum" ]]; then
    echo "gradlew: $url has the SHA-256 $found, expected $sum; nothing was installed" >&2
    exit 1
  fi
  unzip -q "$part/gradle.zip" -d "$part/unpacked"
  mv -T "$part"/unpacked/* "$folder/gradle"
fi

cd "$root"
exec "$folder/gradle/bin/gradle" "$@"
