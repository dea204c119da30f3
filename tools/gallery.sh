#!/usr/bin/env bash
# Makes the pictures of renders/gallery anew: runs the commands that its README names, in
# their order. The animation needs the pages' tools and Chromium beside.
set -euo pipefail
cd "$(dirname "$0")/.."

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export work
sed -n '/^```sh$/,/^```$/p' renders/gallery/README.md | grep -v '^```' | bash -euo pipefail -s
