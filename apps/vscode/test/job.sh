#!/usr/bin/env bash
# Packs the extension and drives it in VS Code: job.sh PYTHON, a Python that has fuzzyctl[lsp].
# A machine that cannot do that (without Node or Chromium, without the packages of npm, too slow) gives a line that says
# so, and no failure. What does not compile, and a check that fails, is one.
set -euo pipefail
PYTHON=$(cd "$(dirname "$1")" && pwd)/$(basename "$1")
cd "$(dirname "$0")/.."
limit=150

skip() {
  echo "VS Code was not driven: $1"
  exit 0
}

# Runs a command within what is left of the limit; its exit code is 124 or 137 when that was too short.
bounded() {
  timeout -k 5 "$((limit > SECONDS ? limit - SECONDS : 1))" "$@"
}

packages() {
  bounded npm ci --ignore-scripts && bounded npm --prefix test run setup
}

for program in timeout node npm "${CHROMIUM:=chromium}"; do
  command -v "$program" > /dev/null || skip "there is no '$program'"
done
CHROMIUM=$(command -v "$CHROMIUM")
export CHROMIUM PYTHON LIMIT=60
export npm_config_prefer_offline=true npm_config_fetch_retries=0 npm_config_fetch_timeout=20000 npm_config_audit=false npm_config_fund=false
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
export TMPDIR=$scratch

if ! packages > "$scratch/log" 2>&1; then
  tail -n 3 "$scratch/log"
  skip "its packages cannot be installed"
fi
# What is done of a command that took too long, or cannot be done here, says nothing about the extension.
beyond() {
  case $1 in
    77) skip "it does not start here" ;;
    124 | 137) skip "that takes longer than $limit s here" ;;
  esac
}

bounded npm run --silent package > "$scratch/log" 2>&1 || {
  status=$?
  cat "$scratch/log"
  beyond "$status"
  exit 1
}
drive() { bounded npm --prefix test run --silent start; }
drive || {
  beyond "$?"
  # A browser on a busy machine may lose a step: a check has failed when it fails twice.
  echo "a check failed, and is run again"
  drive || exit 1
}
