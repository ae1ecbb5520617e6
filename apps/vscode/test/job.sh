#!/usr/bin/env bash
# Packs the extension and drives it in VS Code: job.sh PYTHON, a Python that has fuzzyctl[lsp].
# A machine that cannot do that (without Node or Chromium, without the packages of npm, too slow) gives a line that says
# so, and no failure. What does not compile, and a check that fails, is one.
set -euo pipefail
limit=150
. "$(dirname "$0")/../../../tests/browser/prepare.sh" "VS Code was not driven" "$1"
cd "$(dirname "$0")/.."
export LIMIT=60 TMPDIR=$scratch

# Runs a command within what is left of the limit; its exit code is 124 or 137 when that was too short.
bounded() {
  timeout -k 5 "$((limit > SECONDS ? limit - SECONDS : 1))" "$@"
}

packages() {
  bounded npm ci --ignore-scripts && bounded npm --prefix test run setup
}

if ! packages > "$scratch/log" 2>&1; then
  tail -n 3 "$scratch/log"
  skip "its packages cannot be installed"
fi

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
