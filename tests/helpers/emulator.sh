# Sourced by the scripts that play against a running emulator: how they end, clean up, and start it.
#
# Sets `work`, a directory that is gone at the end, and kills `emulator_pid` and `master_pid` then, if they are set.

readonly READY_LIMIT=10 # seconds until the emulator is ready

cannot() {
    echo "$0: $*" >&2
    exit 2
}

fail() {
    echo "FAIL $*" >&2
    [[ -s $work/emulator.log ]] && sed 's/^/  emulator: /' "$work/emulator.log" | tail -n 40 >&2
    exit 1
}

# Says where the program is, by its full path.
program() {
    [[ -x $1 && -f $1 ]] || cannot "$1 is no executable file; build it with: cargo build --features cli"
    realpath "$1"
}

work=$(mktemp -d)
emulator_pid=
master_pid=
cleanup() {
    for pid in $master_pid $emulator_pid; do
        kill -KILL "$pid" 2>/dev/null || true
        wait "$pid" 2>/dev/null || true
    done
    rm -rf "$work"
}
trap cleanup EXIT
trap 'exit 130' INT
trap 'exit 143' TERM

# Runs `PROGRAM emulate ARGUMENTS...` in the background and waits for its ready line, which is in $work/ready then.
start_emulator() {
    local tenths
    : >"$work/ready"
    "$1" emulate "${@:2}" >"$work/ready" 2>"$work/emulator.log" &
    emulator_pid=$!
    for ((tenths = 0; ; tenths++)); do
        grep -q '^ready ' "$work/ready" && break
        kill -0 "$emulator_pid" 2>/dev/null || fail "emulator: ended before it was ready"
        ((tenths < READY_LIMIT * 10)) || fail "emulator: no ready line within $READY_LIMIT s"
        sleep 0.1
    done
    echo "emulator: $(grep '^ready ' "$work/ready")"
}

# Ends the emulator that start_emulator started.
stop_emulator() {
    kill -TERM "$emulator_pid"
    wait "$emulator_pid" || fail "emulator: ended with $?"
    emulator_pid=
}
