#!/usr/bin/env bash
# Opens pages in Chromium: job.sh PYTHON, a Python that has fuzzyctl.
# A machine that cannot do that (without Node or Chromium, without the packages of npm) gives a line that says so, and no
# failure. A page that fails a check is one.
set -euo pipefail
PYTHON=$(cd "$(dirname "$1")" && pwd)/$(basename "$1")
cd "$(dirname "$0")"

skip() {
  echo "no page was opened: $1"
  exit 0
}

for program in timeout node npm "${CHROMIUM:=chromium}"; do
  command -v "$program" > /dev/null || skip "there is no '$program'"
done
CHROMIUM=$(command -v "$CHROMIUM")
export CHROMIUM npm_config_prefer_offline=true npm_config_fetch_retries=0 npm_config_audit=false npm_config_fund=false
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
timeout -k 5 60 npm ci --ignore-scripts > "$scratch/log" 2>&1 || skip "its packages cannot be installed"
mkdir "$scratch/pages"
"$PYTHON" pages.py "$scratch/pages"
status=0
timeout -k 5 400 node run.mjs "$scratch/pages" || status=$?
case $status in
  0) ;;
  77) skip "Chromium does not start" ;;
  124 | 137) skip "that takes longer than 400 s here" ;;
  *) exit 1 ;;
esac
