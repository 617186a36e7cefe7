#!/bin/sh
# Runs under the systemd of a clean root in which the Debian package is installed: a line of its own as a service,
# sandboxed, with its state kept; a wrong file; a line on a pseudo-terminal; the end of all when the package goes.
set -eu

fail() {
    echo "FAILED: $*"
    systemctl status --no-pager 'profidrive@*' || true
    exit 1
}
# Waits until a command succeeds, ten seconds at most.
until_it() {
    tries=0
    while [ $tries -lt 50 ]; do
        ! "$@" >/dev/null 2>&1 || return 0
        tries=$((tries + 1))
        sleep 0.2
    done
    fail "$*"
}
example=tcp:127.0.0.1:5050

echo "-- the example, as it is installed"
systemctl start profidrive@example
until_it profidrive master --link $example --address 5 status
profidrive master --link $example --address 5 write v-Pos 47
systemctl restart profidrive@example
until_it profidrive master --link $example --address 5 status
profidrive master --link $example --address 5 read v-Pos | grep -w 47 || fail "the state directory keeps nothing"
pid=$(systemctl show -P MainPID profidrive@example)
[ "$(stat -c %u "/proc/$pid")" != 0 ] || fail "it runs as root"
grep -E '^(Seccomp|NoNewPrivs|CapEff|CapBnd):' "/proc/$pid/status"
grep -qE '^Seccomp:[[:space:]]*2' "/proc/$pid/status" || fail "there is no filter of system calls"
grep -qE '^CapBnd:[[:space:]]*0+$' "/proc/$pid/status" || fail "it has capabilities"

echo "-- a line on a pseudo-terminal, with a capture"
cat >/etc/profidrive/line2.toml <<'LINE'
[[line]]
link = "pty:/run/profidrive/line2/bus"
capture = "/var/lib/profidrive/line2/bus.pcapng"

[[line.drive]]
address = 6
LINE
systemctl start profidrive@line2
until_it profidrive master --link /run/profidrive/line2/bus --address 6 status
systemctl stop profidrive@line2
[ "$(systemctl show -P Result profidrive@line2)" = success ] || fail "SIGTERM is no clean end"
profidrive decode --brief /var/lib/private/profidrive/line2/bus.pcapng | tail -n 3

echo "-- a file that is not there"
systemctl start profidrive@none || true
until_it systemctl is-failed profidrive@none
[ "$(systemctl show -P NRestarts profidrive@none)" = 0 ] || fail "a wrong file is tried again"
journalctl -q --no-pager -u profidrive@none -o cat | grep none.toml || fail "the journal does not name the file"

echo "-- the package goes"
dpkg --purge profidrive
[ "$(systemctl is-active profidrive@example)" != active ] || fail "the line still runs"
! [ -e /var/lib/private/profidrive ] || fail "something was kept after purge"
echo "-- passed"
