#!/usr/bin/env bash
# Commits the files of the Unity package to the branch `upm` of a remote, whose URL Unity's Package Manager takes:
#   config/upm_branch.sh build/dist/dev.ml2sensors.unity-VERSION.tgz origin
# Earlier commits stay, since projects that installed them have locked their hashes.
set -euo pipefail
# shellcheck source=/dev/null
source "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/errors.sh"
tarball=$1 remote=$2

files=$(mktemp -d)
trap 'rm -rf "$files"' EXIT
mkdir "$files/package"
tar --extract --gzip --strip-components 1 --directory "$files/package" --file "$tarball"

export GIT_INDEX_FILE=$files/index
git --work-tree "$files/package" add --all --force "$files/package"
parent=()
branch=$(git ls-remote --heads "$remote" upm)
if [[ $branch ]]; then
  git fetch --quiet "$remote" upm
  parent=(-p "$(git rev-parse FETCH_HEAD)")
fi
commit=$(git commit-tree "$(git write-tree)" "${parent[@]}" -m "Unity package $(basename "$tarball" .tgz)")
git push "$remote" "$commit:refs/heads/upm"
