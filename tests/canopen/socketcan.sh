#!/usr/bin/env bash
# Show that emulated nodes take part in a CAN bus of Linux: a virtual machine with the kernel of Debian and the interface
# vcan0, an emulator with three nodes on it, and 'profidrive master' on it.
#
#   KERNEL=boot/vmlinuz-VERSION MODULES=lib/modules/VERSION tests/canopen/socketcan.sh PATH-OF-PROFIDRIVE
#
# PROFIDRIVE was built with the feature socketcan. Needs qemu-system-x86_64, cpio, ip (iproute2) and busybox (static); KERNEL
# and MODULES are parts of an unpacked package linux-image-VERSION-amd64 (apt-get download, dpkg -x). Neither KVM nor network
# is used. Exit status 0 if every step passed, 1 with lines beginning with FAIL if not, 2 if the script cannot run here.
#
# Not part of .ci: the package of the kernel is 70 MB.
set -euo pipefail

cannot() {
    echo "cannot run: $1" >&2
    exit 2
}

profidrive=$(realpath "${1:?PATH-OF-PROFIDRIVE}")
kernel=${KERNEL:?vmlinuz of linux-image-amd64}
modules=${MODULES:?lib/modules/VERSION of linux-image-amd64}
for tool in qemu-system-x86_64 cpio busybox ip; do
    command -v "$tool" >/dev/null || cannot "$tool is missing"
done
root=$(mktemp -d)
trap 'rm -rf "$root"' EXIT
mkdir -p "$root"/{bin,programs,proc,sys,dev,tmp,modules}
cp "$(command -v busybox)" "$root/bin/busybox"
cp "$profidrive" "$root/programs/profidrive"
ip=$(command -v ip)
cp -L "$ip" "$root/programs/ip"
# What they are linked with, at the same places.
{ ldd "$profidrive"; ldd "$ip"; } | sort -u | grep -o '/[^ ]*' | while read -r library; do
    mkdir -p "$root$(dirname "$library")"
    cp -L "$library" "$root$library"
done
for module in net/can/can net/can/can-raw drivers/net/can/dev/can-dev drivers/net/can/vcan; do
    cp "$modules/kernel/$module.ko" "$root/modules/" || cannot "$module is not in $modules"
done
cat >"$root/init" <<'INIT'
#!/bin/busybox sh
/bin/busybox --install -s /bin
mount -t proc proc /proc
mount -t sysfs sys /sys
mount -t devtmpfs dev /dev
export PATH=/programs:/bin
for module in can can-raw can-dev vcan; do insmod /modules/$module.ko; done
step() {
    if "$@"; then echo "PASS $*"; else echo "FAIL $*"; fi
}
step ip link add dev vcan0 type vcan
step ip link set vcan0 up
profidrive emulate --node 5 --node 6,device=ap10 --node 7,device=asda-a2 --link socketcan:vcan0 >/tmp/ready 2>/tmp/log &
for _ in 1 2 3 4 5 6 7 8 9 10; do grep -q ready /tmp/ready && break; sleep 1; done
cat /tmp/ready
for node in 5 6 7; do
    step profidrive master --link socketcan:vcan0 --node $node read 1000
    step profidrive master --link socketcan:vcan0 --node $node status
done
step profidrive master --link socketcan:vcan0 --node 5 write v-Pos 100
step profidrive master --link socketcan:vcan0 --node 5 move 800 --yes
step profidrive master --link socketcan:vcan0 --node 7 write 6081 12800000
step profidrive master --link socketcan:vcan0 --node 7 move 1280000 --yes
# The interface goes away: the emulator says so and ends.
emulator=$!
step ip link set vcan0 down
sleep 2
if kill -0 $emulator 2>/dev/null; then echo "FAIL the emulator goes on without its interface"; fi
cat /tmp/log
echo ALL-DONE
poweroff -f
INIT
chmod +x "$root/init"
(cd "$root" && find . | cpio --quiet -o -H newc | gzip -1) >"$root.cpio.gz"
trap 'rm -rf "$root" "$root.cpio.gz" "$root.log"' EXIT
timeout 600 qemu-system-x86_64 -m 512 -nographic -no-reboot -cpu max -kernel "$kernel" -initrd "$root.cpio.gz" \
    -append 'console=ttyS0 quiet panic=1 rdinit=/init' </dev/null | tee "$root.log"
grep -q ALL-DONE "$root.log" || { echo "FAIL the machine did not come to its end"; exit 1; }
! grep -q FAIL "$root.log"
