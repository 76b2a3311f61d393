#!/usr/bin/env bash
# Bundles the parts of three.js that the page of `ml2-receiver view` uses into OUTPUT, one minified file. The bundle is
# committed, so that users need neither Node nor a network.
# Usage: bundle.sh OUTPUT
set -euo pipefail
# shellcheck source=/dev/null
source "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/../errors.sh"
output=$(realpath --canonicalize-missing "$1")
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

mkdir -p build/three
cp config/three/*.json config/three/three.js build/three
cd build/three
npm ci --no-audit --no-fund --loglevel error
node_modules/.bin/esbuild three.js --bundle --minify --format=esm --legal-comments=inline --log-level=error --outfile="$output"
