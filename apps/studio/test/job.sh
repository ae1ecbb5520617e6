#!/usr/bin/env bash
# Builds the studio and drives it in Chromium: job.sh PYTHON, a Python that has fuzzyctl.
# A machine that cannot do that (without Node or Chromium, without the packages of npm, too slow) gives a line that says
# so, and no failure. A check that fails, and a measure that is missed, is one.
set -euo pipefail
PYTHON=$(cd "$(dirname "$1")" && pwd)/$(basename "$1")
cd "$(dirname "$0")/.."
limit=300

skip() {
  echo "the studio was not driven: $1"
  exit 0
}

for program in timeout node npm "${CHROMIUM:=chromium}"; do
  command -v "$program" > /dev/null || skip "there is no '$program'"
done
CHROMIUM=$(command -v "$CHROMIUM")
export CHROMIUM PYTHON
export npm_config_prefer_offline=true npm_config_fetch_retries=0 npm_config_fetch_timeout=20000 npm_config_audit=false npm_config_fund=false
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
for folder in . test; do
  timeout -k 5 90 npm --prefix "$folder" ci --ignore-scripts > "$scratch/log" 2>&1 || skip "its packages cannot be installed"
done
node build.mjs
node test/bits.mjs
status=0
export PICTURES=${PICTURES:-$scratch/pictures}
timeout -k 5 "$limit" node test/run.mjs || status=$?
case $status in
  0) ;;
  124 | 137) skip "that takes longer than $limit s here" ;;
  *) exit 1 ;;
esac
"$PYTHON" ../../tests/e2e/pictures.py --studio "$PICTURES"
