# What the jobs that drive a browser share; they source it with what is not done on a machine that cannot, and a Python.
# It sets PYTHON, CHROMIUM, npm and `scratch`, a folder that goes at the end. `limit` is the job's, in seconds.
not_done=$1
PYTHON=$(cd "$(dirname "$2")" && pwd)/$(basename "$2")

skip() {
  echo "$not_done: $1"
  exit 0
}

# Ends the job without a failure for the exit code of a command that cannot start here, or took too long.
beyond() {
  case $1 in
    77) skip "it does not start here" ;;
    124 | 137) skip "that takes longer than $limit s here" ;;
  esac
}

for program in timeout node npm "${CHROMIUM:=chromium}"; do
  command -v "$program" > /dev/null || skip "there is no '$program'"
done
CHROMIUM=$(command -v "$CHROMIUM")
export CHROMIUM PYTHON
export npm_config_prefer_offline=true npm_config_fetch_retries=0 npm_config_fetch_timeout=20000 npm_config_audit=false npm_config_fund=false
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
