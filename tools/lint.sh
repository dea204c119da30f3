#!/usr/bin/env bash
# Lints the sources with clang-tidy, without precompiled headers: a file that compiles
# only because of them fails here.
#
#   tools/lint.sh [--minutes N]   what changed since the commit that .ci/linted names
#   tools/lint.sh --all           every source; if all are clean, writes .ci/linted
#
# The last changed come first. After N minutes no further file is begun, and those left
# out are named. A file found clean is not read again until it, a header it includes or
# .clang-tidy changes, so a run that was stopped goes on where it was (build-lint/clean).
set -euo pipefail
cd "$(dirname "$0")/.."

all=no minutes=600
while [[ $# -gt 0 ]]; do
  case $1 in
    --all) all=yes ;;
    --minutes) minutes=$2 && shift ;;
    *) sed -n '2,/^set/{/^#/s/^# \{0,1\}//p}' "$0" >&2 && exit 2 ;;
  esac
  shift
done

build=${CALTWIN_LINT_BUILD:-build-lint}
mkdir -p "$build/clean"
# Debian's 16 matches every header of the system too, for four fifths of its time.
tidy=$build/tidy/bin/clang-tidy
if [[ ! -x $tidy ]]; then
  python3 -m venv "$build/tidy"
  "$build/tidy/bin/pip" install --quiet --disable-pip-version-check --require-hashes \
    --requirement tools/lint_requirements.txt
fi
cmake -S . -B "$build" -G Ninja -DCALTWIN_PCH=OFF -DCALTWIN_UNITY=OFF >/dev/null
unreached=$(mktemp)
trap 'rm -f "$unreached"' EXIT
deadline=$(($(date +%s) + minutes * 60))
export build unreached deadline tidy

# All that is linted. tests/fuzz is a project of its own, compiled by clang anyway.
sources() { git ls-files --cached --others --exclude-standard -- "$@" ':!tests/fuzz'; }

# Files touched by a range of commits or not committed yet, the last touched first.
touched() {
  {
    git diff --name-only HEAD
    git ls-files --others --exclude-standard
    git log --format= --name-only "$1"
  } | grep -E '\.(cc|h)$' | awk '!seen[$0]++'
}

# A header is linted with a source that includes it: its own, else the first.
source_of() {
  local own=${1%.h}.cc
  if [[ $1 != *.h ]]; then
    echo "$1"
  elif [[ -f $own ]]; then
    echo "$own"
  else
    sources '*.cc' | xargs grep -lF "\"$1\"" 2>/dev/null | head -n 1 || true
  fi
}

chosen() {
  local base range=HEAD
  base=$(cat .ci/linted 2>/dev/null || echo none)
  if [[ $all == no ]] && git merge-base --is-ancestor "$base" HEAD 2>/dev/null; then
    range=$base..HEAD
  elif [[ $all == no ]]; then
    echo "lint: .ci/linted names no commit of this history: every source" >&2
  fi
  # Each once, and only what is still there.
  touched "$range" | while read -r file; do source_of "$file"; done |
    awk 'NR == FNR { there[$0]; next } $0 in there && !seen[$0]++' <(sources '*.cc') -
}

# Depends on all that the verdict on a file depends on, within the project.
key() {
  { printf '%s\n' .clang-tidy tools/lint_requirements.txt && clang++-16 -MM -MG -nostdinc -nostdinc++ -I. "$1" | tr -s ' \\\n:' '\n\n\n\n'; } |
    while read -r file; do [[ -f $file ]] && sha256sum "$file"; done | sha256sum | cut -c 1-40
}

lint() {
  local mark
  mark=$build/clean/$(key "$1")
  [[ -e $mark ]] && return 0
  if [[ $(date +%s) -ge $deadline ]]; then
    echo "$1" >>"$unreached"
  elif "$tidy" --quiet --checks=clang-diagnostic-shadow -p "$build" \
    --extra-arg=-Wno-unknown-warning-option "$1" 2>/dev/null; then
    touch "$mark"
  else
    echo "lint: findings in $1"
    return 1
  fi
}
export -f lint key

mapfile -t files < <(chosen)
echo "lint: ${#files[@]} files"
[[ ${#files[@]} -eq 0 ]] && exit 0
printf '%s\0' "${files[@]}" | xargs -0 -n 1 -P "${CALTWIN_LINT_JOBS:-$(nproc)}" bash -c 'lint "$0"'
if [[ -s $unreached ]]; then
  echo "lint: not reached in $minutes min (tools/lint.sh --all reaches them):"
  sed 's/^/  /' "$unreached"
elif [[ $all == yes ]]; then
  if [[ -z $(git status --porcelain -- '*.cc' '*.h' .clang-tidy) ]]; then
    git rev-parse HEAD >.ci/linted
    echo "lint: all clean; .ci/linted names $(cat .ci/linted)"
  else
    echo "lint: all clean, but sources are not committed: .ci/linted stays"
  fi
fi
