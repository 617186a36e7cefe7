#!/usr/bin/env bash
# Operate the panel in headless Chromium.
#
#   tests/browser/run.sh target/debug/profidrive
#
# Needs node (20 or newer) with npm, chromium (CHROMIUM names another binary than /usr/bin/chromium), and once a package
# registry for npm. PROFIDRIVE_SCREENSHOTS=DIR keeps the pictures of docs/ in DIR. Exit status 0 if every test passed, 1 if
# one did not, 2 if the script was called wrongly or cannot run here.
set -euo pipefail

cannot() {
    echo "$0: $*" >&2
    exit 2
}

[[ $# -eq 1 ]] || cannot "usage: $0 PATH-OF-PROFIDRIVE"
[[ -x $1 && -f $1 ]] || cannot "$1 is no executable file; build it with: cargo build --features cli"
PROFIDRIVE=$(realpath "$1")
CHROMIUM=${CHROMIUM:-/usr/bin/chromium}
export PROFIDRIVE CHROMIUM
[[ -z ${PROFIDRIVE_SCREENSHOTS:-} ]] || PROFIDRIVE_SCREENSHOTS=$(realpath "$PROFIDRIVE_SCREENSHOTS")
cd "$(dirname "${BASH_SOURCE[0]}")"

[[ -x $CHROMIUM ]] || cannot "$CHROMIUM not found; on Debian: apt install chromium, or set CHROMIUM"
command -v npm >/dev/null || cannot "npm not found; install Node.js 20 or newer"
node -e 'process.exit(Number(process.versions.node.split(".")[0]) >= 20 ? 0 : 1)' ||
    cannot "Node.js 20 or newer is needed, this is $(node --version)"

# Installed once per lock file.
if ! cmp -s package-lock.json node_modules/.package-lock.json.used; then
    npm ci --no-audit --no-fund --ignore-scripts --loglevel=error || cannot "npm ci failed; is a package registry within reach?"
    cp package-lock.json node_modules/.package-lock.json.used
fi

# One file after the other: several browsers at once on a small machine only wait for each other.
node --test --test-concurrency=1 --test-timeout=600000 ./*.test.js || exit 1
