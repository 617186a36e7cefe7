#!/bin/sh
# Runs under the systemd of a clean root in which the Debian package is installed: a line of its own as a service,
# sandboxed, with its state kept; a wrong file; a line on a pseudo-terminal; the end of all when the package goes.
set -eu

on() { profidrive master --link "$1" --address "$2" --yes --quiet "${@:3}"; }
fail() {
    echo "FAILED: $*"
    systemctl status --no-pager 'profidrive@*' || true
    exit 1
}
example=tcp:127.0.0.1:5050

echo "-- the example, as it is installed"
systemctl start profidrive@example
for _ in 1 2 3 4 5 6 7 8 9 10; do
    profidrive master --link $example --address 5 status >/dev/null 2>&1 && break
    sleep 0.2
done
profidrive master --link $example --address 5 write v-Pos 47
systemctl restart profidrive@example
sleep 0.5
profidrive master --link $example --address 5 read v-Pos | grep -w 47 || fail "the state directory keeps nothing"
ls -l /var/lib/private/profidrive/example
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
sleep 0.5
profidrive master --link /run/profidrive/line2/bus --address 6 status
systemctl stop profidrive@line2
[ "$(systemctl show -P Result profidrive@line2)" = success ] || fail "SIGTERM is no clean end"
profidrive decode --brief /var/lib/private/profidrive/line2/bus.pcapng | tail -n 3

echo "-- a serial port that is not there, and a file that is not there"
printf '[[line]]\nlink = "serial:/dev/ttyS9"\nbaud = 19200\n\n[[line.drive]]\naddress = 5\n' >/etc/profidrive/serial.toml
systemctl start profidrive@none || true
sleep 0.5
[ "$(systemctl show -P NRestarts profidrive@none)" = 0 ] || fail "a wrong file is tried again"
[ "$(systemctl is-failed profidrive@none)" = failed ] || fail "a wrong file is no failure"
journalctl -q --no-pager -u profidrive@none -o cat | grep none.toml || fail "the journal does not name the file"

echo "-- the package goes"
dpkg --purge profidrive
[ "$(systemctl is-active profidrive@example)" != active ] || fail "the line still runs"
! [ -e /var/lib/private/profidrive ] || fail "something was kept after purge"
echo "-- passed"
