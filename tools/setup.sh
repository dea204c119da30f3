#!/usr/bin/env bash
# Installs what building caltwin needs and this machine lacks: packages of Debian 12, and
# MuJoCo in third_party/mujoco. Says nothing where there is nothing to do.
#
#   tools/setup.sh [PACKAGE ...]    these packages too
#   tools/setup.sh --controllers    and the shipped programs that drive the twin
#                                   (docs/klipper.md): kalico, in build/controllers,
#                                   Klipper 0.12, in build/klipper, and Moonraker, in
#                                   build/moonraker; and LinuxCNC
#                                   (docs/linuxcnc.md), where Debian has it
#   tools/setup.sh --clients        and the programs that talk to it as to a real machine
#                                   (docs/clients.md): OctoPrint and grbl-streamer, in
#                                   build/clients, cncjs, in build/clients-node, and Debian's
#                                   pronsole
set -euo pipefail
cd "$(dirname "$0")/.."

packages=(
  clang-16 cmake mold ninja-build
  libeigen3-dev libceres-dev libyaml-cpp-dev libfmt-dev libcli11-dev
  nlohmann-json3-dev libexpected-dev libgtest-dev libgmock-dev libbenchmark-dev
  libboost1.81-dev libosmesa6-dev libpng-dev zlib1g-dev libssl-dev libsqlite3-dev libsqlitecpp-dev libpugixml-dev
  python3 python3-pip python3-numpy python3-yaml
)

as_root() {
  if [[ $(id -u) -eq 0 ]]; then
    "$@"
  elif command -v sudo >/dev/null; then
    sudo "$@"
  else
    echo "setup: not root and no sudo: run as root: $*" >&2
    return 1
  fi
}

# Of the packages named, those that are not installed, one a line.
missing_packages() {
  local package
  for package in "$@"; do
    dpkg-query -W -f '${Status}\n' "$package" 2>/dev/null | grep -q ' installed$' ||
      echo "$package"
  done
}

# Installs the packages named that are missing; the package lists are fetched only where
# they are missing or too old.
install_packages() {
  local missing log
  mapfile -t missing < <(missing_packages "$@")
  [[ ${#missing[@]} -eq 0 ]] && return 0
  echo "setup: installing ${missing[*]}"
  log=$(mktemp)
  local install=(env DEBIAN_FRONTEND=noninteractive apt-get install -y -q
    --no-install-recommends "${missing[@]}")
  if ! as_root "${install[@]}" >"$log" 2>&1; then
    if ! { as_root apt-get update -q && as_root "${install[@]}"; } >"$log" 2>&1; then
      cat "$log" >&2
      echo "setup: apt-get could not install ${missing[*]}" >&2
      return 1
    fi
  fi
  rm -f "$log"
}

# The official wheel holds the library and its headers; no Python of it is run. Platform,
# Python version and ABI are stated so that any Python fetches the same, hashed, file.
install_mujoco() {
  local version=4.0.1 target=third_party/mujoco platform hash
  [[ -e $target/libmujoco.so.$version ]] && return 0
  case $(uname -m) in
    x86_64)
      platform=manylinux_2_28_x86_64
      hash=be28c0c7587347ef996b4de0487264e9da296282082b092bae211a9163e9aed6
      ;;
    aarch64)
      platform=manylinux_2_28_aarch64
      hash=52d934614a56f7d75dcfc2bd8bb72f058b465ecc19a0583a56df242f9505bdb6
      ;;
    *)
      echo "setup: there is no MuJoCo wheel for $(uname -m): unpack your own and" \
        "build with -DMUJOCO_ROOT=" >&2
      return 1
      ;;
  esac
  echo "setup: fetching MuJoCo $version"
  local work
  work=$(mktemp -d)
  echo "mujoco-core==$version --hash=sha256:$hash" >"$work/requirements.txt"
  if ! python3 -m pip download --quiet --disable-pip-version-check --no-deps \
    --only-binary=:all: --require-hashes --platform "$platform" \
    --python-version 3.11 --implementation cp --abi cp311 \
    --dest "$work" -r "$work/requirements.txt"; then
    rm -rf "$work"
    echo "setup: MuJoCo could not be fetched" >&2
    return 1
  fi
  python3 -m zipfile -e "$work"/mujoco_core-*.whl "$work/wheel"
  # Headers, library and licence are all that is kept; renamed into place when whole.
  mkdir -p "$work/mujoco" third_party
  cp -r "$work/wheel/mujoco/include" "$work"/wheel/mujoco/libmujoco.so.* "$work/mujoco/"
  find "$work/wheel" -type f -iname 'LICENSE*' -exec cp {} "$work/mujoco/" \;
  rm -rf "$target" "$target.part"
  mv "$work/mujoco" "$target.part"
  mv "$target.part" "$target"
  rm -rf "$work"
}

# A Python of its own in a folder, with the files that a list names, each by its hash. Says
# nothing where it is there as the list has it. What `ready` names is called with the folder
# before that counts; where anything fails the folder is gone.
install_python() {
  local folder=$1 wanted=$2 ready=$3
  cmp -s "$wanted" "$folder/installed.txt" && return 0
  echo "setup: installing $folder"
  rm -rf "$folder"
  /usr/bin/python3 -m venv "$folder"
  if ! "$folder/bin/pip" install --quiet --disable-pip-version-check --no-deps \
    --only-binary=:all: --require-hashes -r "$wanted"; then
    rm -rf "$folder"
    echo "setup: $folder could not be fetched (Python 3.11 on x86_64 is what" \
      "$wanted is for)" >&2
    return 1
  fi
  if ! "$ready" "$folder"; then
    rm -rf "$folder"
    echo "setup: $folder does not run" >&2
    return 1
  fi
  cp "$wanted" "$folder/installed.txt"
}

# At its first start kalico compiles a helper into its own folder: now, not in a test.
compile_helper() {
  "$1/bin/python" -c 'from klippy import chelper; chelper.get_ffi()'
}

# Klipper's own package cannot be built as it is published: its source is unpacked, its helper
# compiled.
unpack_klipper() {
  local folder=$1
  mkdir -p "$folder/source" "$folder/fetched"
  "$folder/bin/pip" download --quiet --disable-pip-version-check --no-deps --no-build-isolation \
    --no-binary=:all: --require-hashes -r tools/controllers/klipper_source.txt \
    --dest "$folder/fetched" &&
    tar -C "$folder/source" -xzf "$folder"/fetched/*.tar.gz --strip-components=1 &&
    PYTHONPATH="$folder/source" "$folder/bin/python" -c \
      'from klippy.chelper import builder; builder.build_chelper()' &&
    sed "1s|.*|#!$PWD/$folder/bin/python3|" tools/controllers/start_klipper.py >"$folder/bin/klipper" &&
    chmod +x "$folder/bin/klipper" &&
    "$folder/bin/klipper" --help >/dev/null &&
    cp tools/controllers/klipper_source.txt "$folder/source.txt"
}

install_klipper() {
  cmp -s tools/controllers/klipper_source.txt build/klipper/source.txt || rm -rf build/klipper
  install_python build/klipper tools/controllers/klipper_requirements.txt unpack_klipper
}

# The programs that drive the twin.
install_controllers() {
  install_python build/controllers tools/controllers/requirements.txt compile_helper
}

has_moonraker() {
  "$1/bin/moonraker" --help >/dev/null
}

# The server of Klipper's web pages. Its packages are not kalico's: a Python of its own.
install_moonraker() {
  install_python build/moonraker tools/controllers/moonraker_requirements.txt has_moonraker
}

# Debian's: 2.9.0 is what Debian 12 has and what tests/controllers was run with.
install_linuxcnc() {
  install_packages linuxcnc-uspace linuxcnc-uspace-dev || return 1
  local version
  version=$(dpkg-query -W -f '${Version}' linuxcnc-uspace)
  dpkg --compare-versions "$version" ge 2.9.0~ && return 0
  echo "setup: LinuxCNC $version is older than 2.9" >&2
  return 1
}

# Three of the packages are published as source only: they are built with what the list has,
# not with whatever is the newest.
install_clients() {
  local folder=build/clients wanted=tools/clients/requirements.txt
  cmp -s "$wanted" "$folder/installed.txt" && return 0
  echo "setup: installing $folder"
  rm -rf "$folder"
  /usr/bin/python3 -m venv "$folder"
  local pip=("$folder/bin/pip" install --quiet --disable-pip-version-check --no-deps --require-hashes)
  grep -A 1 -E '^(setuptools|wheel|hatchling|packaging|pathspec|pluggy|trove-classifiers)==' "$wanted" | grep -v '^--' >"$folder/builders.txt"
  if ! { "${pip[@]}" -r "$folder/builders.txt" &&
    "${pip[@]}" --no-build-isolation --only-binary=:all: \
      --no-binary=grbl-streamer,gcode-machine,netifaces -r "$wanted" &&
    "$folder/bin/octoprint" --version >/dev/null; }; then
    rm -rf "$folder"
    echo "setup: $folder could not be installed (Python 3.11 on x86_64 is what $wanted is for)" >&2
    return 1
  fi
  cp "$wanted" "$folder/installed.txt"
}

# npm checks each package against the lock file's hash; no script of theirs is run.
install_node_clients() {
  local folder=build/clients-node
  cmp -s tools/clients/package-lock.json "$folder/installed.json" && return 0
  echo "setup: installing $folder"
  rm -rf "$folder"
  mkdir -p "$folder"
  cp tools/clients/package.json tools/clients/package-lock.json "$folder/"
  local node=$PWD/third_party/node # tools/pages.sh fetches it.
  local npm=(npm)
  [[ -x $node/bin/node ]] && npm=("$node/bin/node" "$node/lib/node_modules/npm/bin/npm-cli.js")
  if ! (cd "$folder" && "${npm[@]}" ci --silent --no-audit --no-fund --ignore-scripts); then
    rm -rf "$folder"
    echo "setup: $folder could not be installed" >&2
    return 1
  fi
  cp tools/clients/package-lock.json "$folder/installed.json"
}

if [[ ${1:-} == --clients ]]; then
  install_packages "${packages[@]}" gcc libc6-dev python3-dev python3-venv "${@:2}"
  install_packages pronsole || echo "setup: without pronsole its test is skipped" >&2
  [[ -x third_party/node/bin/node ]] || command -v npm >/dev/null || install_packages nodejs npm
  install_mujoco
  install_clients || echo "setup: without OctoPrint and grbl-streamer their tests are skipped" >&2
  install_node_clients || echo "setup: without cncjs its test is skipped" >&2
elif [[ ${1:-} == --controllers ]]; then
  install_packages "${packages[@]}" gcc libc6-dev python3-venv "${@:2}"
  install_mujoco
  install_controllers
  install_klipper || echo "setup: without Klipper 0.12 its test is skipped" >&2
  install_moonraker || echo "setup: without Moonraker its test is skipped" >&2
  install_linuxcnc ||
    echo "setup: there is no LinuxCNC 2.9 for this system: its tests are skipped" >&2
else
  install_packages "${packages[@]}" "$@"
  install_mujoco
fi
