#!/bin/sh
# Runs in a container of the image, as its user: the arguments of the image emulate a line, which keeps what a master writes.
set -eu
[ "$(id -u)" != 0 ]
emulate() {
    # Or the line of the run before is read.
    rm -f /tmp/ready
    profidrive "$@" >/tmp/ready &
    for _ in 1 2 3 4 5 6 7 8 9 10; do
        grep -q ^ready /tmp/ready && break
        sleep 0.2
    done
    link=$(sed -n 's/.*link=\([^ ]*\).*/\1/p' /tmp/ready)
}
emulate "$@"
profidrive master --link "$link" --address 5 write v-Pos 47
kill $!
wait $!
emulate "$@"
profidrive master --link "$link" --address 5 read v-Pos | grep -w 47
kill $!
wait $!
ls /var/lib/profidrive
