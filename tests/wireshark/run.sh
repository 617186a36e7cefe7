#!/usr/bin/env bash
# Read captures of the emulator with Wireshark's own programs.
#
#   tests/wireshark/run.sh target/debug/profidrive [--update]
#
# 1. A run of the emulator that ends with SIGKILL in the middle of the traffic: capinfos and tshark read its capture,
#    the link type is 257, and it holds every telegram that the master has sent and seen answered, in its order.
# 2. A recorded session, through docs/wireshark/profibus.lua: the fields are those of session.fields. --update writes
#    that file instead; look at the difference.
# 3. Answers that a drive never gives through the same: they do not read like values.
# 4. Octets that make no sense through the same: no error of Lua.
#
# Needs capinfos and tshark (on Debian: apt install tshark) and python3. Exit status 0 if every step passed, 1 with a
# line beginning with FAIL if one did not, 2 if the script was called wrongly or cannot run here.
set -euo pipefail

readonly KILL_AFTER=2000     # telegrams in the log of the master when the emulator is killed
readonly GARBAGE=(4000 2611) # packets and seed

here=$(realpath "$(dirname "${BASH_SOURCE[0]}")")
. "$here/../helpers/emulator.sh"

[[ $# -eq 1 || $# -eq 2 && $2 == --update ]] || cannot "usage: $0 PATH-OF-PROFIDRIVE [--update]"
emulator=$(program "$1")
update=${2:-}
dissector=$(realpath "$here/../../docs/wireshark/profibus.lua")
for program in tshark capinfos python3; do
    command -v "$program" >/dev/null || cannot "$program not found (on Debian: apt install tshark python3)"
done

# No settings or plugins of whoever runs this, no lookups of names.
export HOME=$work XDG_CONFIG_HOME=$work LC_ALL=C.UTF-8 TZ=UTC
sharks() {
    tshark -n "$@" 2>"$work/tshark.log" || fail "tshark $*: $(tail -n 3 "$work/tshark.log")"
}
dissected() {
    sharks -X "lua_script:$dissector" "$@"
}

echo "== SIGKILL in the middle of the traffic"
capture=$work/bus.pcapng
start_emulator "$emulator" --link "pty:$work/bus" --capture "$capture"
python3 "$here/master.py" forever "$work/bus" "$work/master" 2>"$work/master.log" &
master_pid=$!
for ((tenths = 0; ; tenths++)); do
    [[ -e $work/master ]] && (($(wc -l <"$work/master") >= KILL_AFTER)) && break
    kill -0 "$master_pid" 2>/dev/null || fail "master: ended early: $(cat "$work/master.log")"
    ((tenths < 600)) || fail "master: not $KILL_AFTER telegrams within 60 s"
    sleep 0.1
done
{ kill -KILL "$emulator_pid" && wait "$emulator_pid"; } 2>/dev/null || true
emulator_pid=
wait "$master_pid" || fail "master: $(cat "$work/master.log")"
master_pid=

link_type=$(python3 - "$capture" <<'PYTHON'
import struct, sys
octets = open(sys.argv[1], "rb").read()
interface = struct.unpack_from("<I", octets, 4)[0]
print(struct.unpack_from("<H", octets, interface + 8)[0])
PYTHON
)
((link_type == 257)) || fail "link type $link_type, expected 257"
# capinfos has no name for link type 257 and says so on stderr.
packets=$(capinfos -c -M -T -r "$capture" 2>/dev/null | cut -f 2) || fail "capinfos cannot read the capture"
sharks -r "$capture" -T fields -e frame.p2p_dir -e data.data | tr '\t' ' ' >"$work/captured"
(($(wc -l <"$work/captured") == packets)) || fail "capinfos counts $packets packets, tshark $(wc -l <"$work/captured")"
# Up to the last answer: a request behind it may never have reached the emulator.
answered=$(grep -n '^0 ' "$work/master" | tail -n 1 | cut -d : -f 1)
head -n "$answered" "$work/master" >"$work/held"
head -n "$answered" "$work/captured" | diff -u "$work/held" - >"$work/difference" ||
    fail "the capture is not what the master sent and received:$(head -n 20 "$work/difference")"
((packets - answered <= 2)) || fail "$packets packets, but the master knows of $answered and at most 2 on their way"
echo "SIGKILL: link type $link_type, $packets packets, all $answered telegrams of the master are there"

echo "== a recorded session through profibus.lua"
fields=(frame.number frame.p2p_dir _ws.col.Source _ws.col.Destination _ws.col.Info
    profibus.fdl.sd profibus.fdl.da profibus.fdl.sa profibus.fdl.dsap profibus.fdl.ssap profibus.fdl.fc
    profibus.fdl.fc.fcb profibus.fdl.fc.fcv profibus.fdl.fc.function profibus.fdl.fc.status profibus.fdl.fcs.good
    profibus.fdl.retry profibus.invalid profibus.request_in profibus.response_in profibus.dp.service
    profibus.dp.identifier profibus.dp.prm.lock_req profibus.dp.prm.wd_on profibus.dp.prm.watchdog
    profibus.dp.prm.min_tsdr profibus.dp.prm.ident profibus.dp.prm.group profibus.dp.prm.user
    profibus.dp.diag.station_not_ready profibus.dp.diag.prm_req profibus.dp.diag.prm_fault profibus.dp.diag.cfg_fault
    profibus.dp.diag.master_add profibus.dp.diag.ident profibus.dp.diag.block profibus.dp.gc.clear_data
    profibus.dp.gc.sync profibus.dp.gc.freeze profibus.dp.gc.group profibus.dp.ssa.address
    ppo.pkw.ak ppo.pkw.pnu ppo.pkw.ind ppo.pkw.pwe ppo.pkw.value ppo.pkw.error ppo.stw ppo.stw.on ppo.stw.start
    ppo.hsw ppo.zsw ppo.zsw.operation_enabled ppo.zsw.fault ppo.zsw.target_reached ppo.zsw.job_toggle ppo.hiw
    _ws.expert.message)
dissected -2 -r "$here/session.pcapng" -T fields -E header=y -E separator='|' -E occurrence=a -E aggregator=' ' \
    "${fields[@]/#/-e}" >"$work/fields"
if [[ $update == --update ]]; then
    cp "$work/fields" "$here/session.fields"
    echo "session.fields was written anew"
else
    diff -u "$here/session.fields" "$work/fields" >"$work/difference" ||
        fail "the fields differ from session.fields: $(head -n 20 "$work/difference")"
fi
# The filters of docs/wireshark/README.md find something, each in this session.
sed -n '/^## Filters/,$ s/^    //p' "$here/../../docs/wireshark/README.md" | while read -r filter; do
    found=$(dissected -2 -r "$here/session.pcapng" -Y "$filter" | wc -l)
    ((found > 0)) || fail "the filter of the README finds nothing: $filter"
    echo "$found packets: $filter"
done

echo "== answers that are no values through profibus.lua"
python3 -B - "$here" "$work/answers.pcapng" <<'PYTHON'
import sys
sys.path.insert(0, sys.argv[1])
from garbage import write
from master import telegram
words = ((0x33FA, 0x0200, 0, 9), (0xA3FA, 0, 0, 9), (0xF3FA, 0, 0, 9), (0x23FA, 0, 0, 9), (0, 0, 0, 0))
pkws = [b"".join(word.to_bytes(2, "big") for word in answer) for answer in words]
write(sys.argv[2], [telegram(2, 5, 0x08, pkw + bytes((0x2B, 0x23, 0, 0, 0, 0))) for pkw in pkws])
PYTHON
dissected -2 -r "$work/answers.pcapng" -T fields -e _ws.col.Info >"$work/answers"
diff -u - "$work/answers" >"$work/difference" <<'ANSWERS' || fail "answers read otherwise: $(<"$work/difference")"
Data_Exchange description of 1018 Calibration value, element 2: 00000009, ZSW 2B23 (OFF2 given, stands still, not ready to travel), HIW 0
Data_Exchange spontaneous answer 10 to 1018 Calibration value, ZSW 2B23 (OFF2 given, stands still, not ready to travel), HIW 0
Data_Exchange reserved answer 15 to 1018 Calibration value, ZSW 2B23 (OFF2 given, stands still, not ready to travel), HIW 0
Data_Exchange 1018 Calibration value = 9, ZSW 2B23 (OFF2 given, stands still, not ready to travel), HIW 0
Data_Exchange ZSW 2B23 (OFF2 given, stands still, not ready to travel), HIW 0
ANSWERS
cat "$work/answers"

echo "== a watchdog that expired, and words of the system status word"
python3 -B - "$here" "$work/watchdog.pcapng" <<'PYTHON'
import sys
sys.path.insert(0, sys.argv[1])
from garbage import write
from master import SRD, telegram
acknowledge = b"\xe5"
def exchange(job, reply):
    return [telegram(5, 2, SRD, bytes(job) + bytes(6)), telegram(2, 5, 0x08, bytes(reply) + bytes((0x2B, 0x23, 0, 0, 0, 0)))]
prm = telegram(0x85, 0x82, SRD, bytes((61, 62, 0x88, 1, 6, 11, 0x0A, 0xC5, 0)))
nothing, read = bytes(8), bytes((0x13, 0xFC)) + bytes(6)
word = bytes((0x13, 0xFC, 0, 0, 0, 0, 0x09, 0x80))
# 25 ms apart, a watchdog of 60 ms: the owner is late once behind the three requests of another master.
foreign = [telegram(0x85, 0x83, SRD, bytes((60, 62))), telegram(0x83, 0x85, 0x08, bytes((62, 60, 0, 0x0C, 0, 2, 0x0A, 0xC5)))]
packets = [prm, acknowledge] + exchange(nothing, nothing) + exchange(read, word) + foreign + exchange(nothing, nothing)
write(sys.argv[2], packets, 25000)
PYTHON
dissected -2 -r "$work/watchdog.pcapng" -T fields -e frame.number -e _ws.expert.message -e _ws.col.Info |
    sed -n '/watchdog\|1020/p' >"$work/watchdog"
diff -u - "$work/watchdog" >"$work/difference" <<'WATCHDOG' || fail "the watchdog reads otherwise: $(<"$work/difference")"
1		Set_Prm lock, watchdog 60 ms, ident 0AC5
5		Data_Exchange read 1020 System status word, STW 0000 (OFF1, OFF2, stop, intermediate stop), HSW 0
6		Data_Exchange 1020 System status word = 0980 (motor released, FAULT, not ready to travel), ZSW 2B23 (OFF2 given, stands still, not ready to travel), HIW 0
9	The DP watchdog has expired: 75 ms without an answered request of the owner, the watchdog is 60 ms	Data_Exchange [watchdog expired] STW 0000 (OFF1, OFF2, stop, intermediate stop), HSW 0
WATCHDOG
cat "$work/watchdog"

echo "== records, alarms, connections and parameters of DP-V1 through profibus.lua"
python3 -B - "$here" "$work/dpv1.pcapng" <<'PYTHON'
import sys
sys.path.insert(0, sys.argv[1])
from garbage import write
telegrams = """
68 09 09 68 87 82 7D 33 33 5E 01 0A 08 5D 16
E5
68 05 05 68 87 82 5D 33 33 CC 16
68 0D 0D 68 82 87 08 33 33 5E 01 0A 04 11 22 33 44 8E 16
68 0D 0D 68 87 82 7D 33 33 5F 01 0A 04 AA BB CC DD 68 16
68 09 09 68 82 87 08 33 33 DE 80 B0 00 85 16
68 09 09 68 87 82 7D 33 33 5C 01 02 01 4C 16
68 19 19 68 87 83 6D 31 32 57 00 00 00 00 64 01 00 00 00 00 00 00 02 00 02 00 00 00 00 9A 16
68 09 09 68 83 87 08 32 31 56 30 00 0A 05 16
68 13 13 68 87 82 7D 33 33 5F 00 2F 0A 01 01 00 01 10 06 03 C4 00 00 64 16
68 1B 1B 68 82 87 08 33 33 5E 00 2F 12 01 01 00 01 06 06 00 2A 00 01 00 64 07 EA 0B 16 00 01 C7 16
68 17 17 68 87 82 7D 33 33 5F 00 2F 0E 03 02 00 01 10 00 03 C5 00 00 42 01 00 01 AA 16
68 15 15 68 82 87 08 33 33 5E 00 2F 0C 04 81 00 02 42 01 00 01 44 01 00 00 20 16
"""
write(sys.argv[2], [bytes.fromhex(line) for line in telegrams.split("\n") if line])
PYTHON
dissected -2 -r "$work/dpv1.pcapng" -T fields -e _ws.col.Info >"$work/dpv1"
diff -u - "$work/dpv1" >"$work/difference" <<'DPV1' || fail "DP-V1 reads otherwise: $(<"$work/difference")"
MS1 Read slot 1 index 10
MS1 short acknowledge
MS1
MS1 Read slot 1 index 10: 11223344
MS1 Write slot 1 index 10: AABBCCDD
MS1 Read refused: B0, invalid index
MS1 Alarm_Ack slot 1 type 2 number 0
MS2 resource manager Initiate
MS2 resource manager RM SAP 48
MS1 Write slot 0 index 47: read PNU 964.0
MS1 Read slot 0 index 47: read 002A0001006407EA0B160001
MS1 Write slot 0 index 47: change PNU 965.0, 0001
MS1 Read slot 0 index 47: read 0001, error 00, no such parameter
DPV1
cat "$work/dpv1"
for filter in "profibus.v1.index == 47 and profibus.parameter.pnu == 964" "profibus.v1.error == 0xB0" "profibus.parameter.error == 0"; do
    (($(dissected -2 -r "$work/dpv1.pcapng" -Y "$filter" | wc -l) == 1)) || fail "the filter finds not one packet: $filter"
done

echo "== garbage through profibus.lua"
python3 "$here/garbage.py" "$work/garbage.pcapng" "${GARBAGE[@]}"
dissected -2 -r "$work/garbage.pcapng" -V >"$work/garbage"
errors=$(grep -c 'Lua Error' "$work/garbage" "$work/tshark.log" || true)
grep -q ':[1-9]' <<<"$errors" && fail "errors of Lua: $(grep -h 'Lua Error' "$work/garbage" "$work/tshark.log" | sort | uniq -c)"
(($(grep -c '^PROFIBUS,' "$work/garbage") > GARBAGE[0] / 2)) || fail "the dissector did not see the packets"
echo "OK: captures are read"
