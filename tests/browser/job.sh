#!/usr/bin/env bash
# Opens pages in Chromium: job.sh PYTHON, a Python that has fuzzyctl.
# A machine that cannot do that (without Node or Chromium, without the packages of npm) gives a line that says so, and no
# failure. A page that fails a check is one.
set -euo pipefail
limit=400
. "$(dirname "$0")/prepare.sh" "no page was opened" "$1"
cd "$(dirname "$0")"

timeout -k 5 60 npm ci --ignore-scripts > "$scratch/log" 2>&1 || skip "its packages cannot be installed"
export PICTURES=${PICTURES:-$scratch/pictures}
mkdir "$scratch/pages"
"$PYTHON" pages.py "$scratch/pages"
timeout -k 5 "$limit" node run.mjs "$scratch/pages" || {
  beyond "$?"
  exit 1
}
"$PYTHON" ../e2e/pictures.py --browser "$PICTURES"
