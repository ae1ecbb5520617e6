#!/usr/bin/env bash
# Builds the studio and drives it in Chromium: job.sh PYTHON, a Python that has fuzzyctl and hatchling. What is driven are
# the wheels of fuzzyctl and of fuzzyctl-studio in a folder outside of the checkout.
# A machine that cannot do that (without Node or Chromium, without the packages of npm, too slow) gives a line that says
# so, and no failure. A check that fails, and a measure that is missed, is one.
set -euo pipefail
limit=300
. "$(dirname "$0")/../../../tests/browser/prepare.sh" "the studio was not driven" "$1"
cd "$(dirname "$0")/.."

for folder in . test; do
  timeout -k 5 90 npm --prefix "$folder" ci --ignore-scripts > "$scratch/log" 2>&1 || skip "its packages cannot be installed"
done
"$PYTHON" -m pip install -q --no-deps --no-build-isolation --target "$scratch/site" ../.. .
node test/bits.mjs
export PICTURES=${PICTURES:-$scratch/pictures}
PYTHONPATH=$scratch/site timeout -k 5 "$limit" node test/run.mjs || {
  beyond "$?"
  exit 1
}
"$PYTHON" ../../tests/e2e/pictures.py --studio "$PICTURES"
