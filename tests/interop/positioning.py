#!/usr/bin/env python3
"""Commission and move one emulated AG03 with pyprofibus 1.13 as DP class-1 master.

pyprofibus and its serial layer run as they are; this file is only the application on top: a configuration, the seven
output words, and what the seven input words must say. Each step is printed in words. Exit status 0 if all went well,
1 with one line `FAIL step: expected ..., got ...` otherwise.

Masks and values of the status word are the patterns of the manual's flow charts (`ag03.md` 5).
"""

import argparse
import io
import signal
import struct
import sys
import termios
import time

from pyprofibus.conf import PbConf
from pyprofibus.util import ProfibusError

WATCHDOG_MS = 1000
GROUP = 1
CONNECT_LIMIT = 15.0  # seconds; leaves room for a slave that searches the baud rate
REPLY_LIMIT = 3.0
STATE_LIMIT = 3.0
FREEZE_TIME = 0.3
TRAVEL_LIMIT = 10.0  # on top of the time the distance takes
TOTAL_LIMIT = 120
INCREMENTS_PER_SECOND = 30 / 60 * 1600  # v-Pos default, 30 rpm

# Our GSD describes a compact station: pyprofibus takes its one module, F3 F2, without a `module_1` line.
# Sizes are seen from the slave: input_size is what the master sends.
CONFIGURATION = """
[PROFIBUS]
debug={debug}
[PHY]
type=serial
dev={port}
baud={baud}
[DP]
master_class=1
master_addr=2
[SLAVE_0]
name=AG03
addr={address}
gsd={gsd}
sync_mode=1
freeze_mode=1
group_mask={group}
watchdog_ms={watchdog}
input_size=14
output_size=14
"""

# name, mask, value
READY_TO_RUN = ("ready-to-run", 0xAB6F, 0x2B23)
OPERATION_ENABLED = ("operation enabled", 0x2B7F, 0x2B37)
READY_TO_TRAVEL = ("ready-to-travel", 0xEB7F, 0xAB37)
TRAVEL_JOB_ACTIVE = ("travel job active", 0xEA7F, 0x0A37)

FAULT = 1 << 3
TARGET_REACHED = 1 << 10
JOB_ACKNOWLEDGED = 1 << 12
STANDS_STILL = 1 << 13

PNU_WINDOW = 1009
PNU_LIMIT_1 = 1016
PNU_CALIBRATION_VALUE = 1018

READ = 1
WRITE_DOUBLE_WORD = 3
VALUE_WORD = 1
VALUE_DOUBLE_WORD = 2


class Failure(Exception):
    """A step did not go as it must."""

    def __init__(self, step, expected, got):
        super().__init__(f"FAIL {step}: expected {expected}, got {got}")


def say(text):
    print(text, flush=True)


class Drive:
    """One drive on the bus: seven words out, seven words in."""

    # After a change of the outputs this many inputs may still be older than the change: one on its way already, one
    # that answers the new outputs from a buffer filled before, one more for the application cycle of the drive.
    LATENCY = 3

    def __init__(self, port, baud, gsd, address, debug):
        configuration = CONFIGURATION.format(
            port=port, baud=baud, gsd=gsd, address=address, watchdog=WATCHDOG_MS, group=GROUP, debug=debug
        )
        conf = PbConf(io.StringIO(configuration))
        self.master = conf.makeDPM()
        self.slave = conf.slaveConfs[0].makeDpSlaveDesc()
        self.master.addSlave(self.slave)
        self.master.initialize()
        self.job = (0, 0, 0)  # PKE, IND, PWE
        self.stw = 0
        self.hsw = 0
        self.reply = (0, 0, 0)
        self.zsw = 0
        self.hiw = 0
        self.exchanges = 0
        self.answered = False
        self.trouble = None
        self._latency = self.LATENCY

    def close(self):
        self.master.destroy()

    def set_words(self, stw, hsw=None):
        self.stw = stw
        self.hsw = self.hsw if hsw is None else hsw
        self._latency = self.LATENCY

    def set_job(self, pke, pwe):
        self.job = (pke, 0, pwe & 0xFFFFFFFF)
        self._latency = self.LATENCY

    def poll(self):
        """Run the master once. True if there are inputs that may already answer the newest outputs."""
        self.slave.setMasterOutData(struct.pack(">HHLHl", *self.job, self.stw, self.hsw))
        try:
            self.master.run()
        except ProfibusError as error:  # how pyprofibus surfaces an RS reply in Data_Exchange
            self.trouble = str(error)
        self.answered = self.answered or self.slave.isConnecting()
        inputs = self.slave.getMasterInData()
        if inputs is None:
            # pyprofibus takes at least three runs for one telegram: do not sleep longer than the shortest of them.
            time.sleep(0.0003)
            return False
        *reply, self.zsw, self.hiw = struct.unpack(">HHLHl", bytes(inputs))
        self.reply = tuple(reply)
        self.exchanges += 1
        self._latency = max(0, self._latency - 1)
        return self._latency == 0

    def wait(self, step, limit, condition, expected, got):
        """Exchange data until `condition()`; `got()` says what there is instead when the time is over."""
        start = time.monotonic()
        while True:
            try:
                if self.poll() and condition():
                    return time.monotonic() - start
            except (OSError, termios.error) as error:  # pyprofibus does not catch it when the other end hangs up
                raise Failure(step, expected, f"the port is gone ({error})") from error
            if self.exchanges and not self.slave.isConnected():
                raise Failure(step, expected, f"Data_Exchange was lost ({self.trouble or 'no reply'})")
            if time.monotonic() - start > limit:
                raise Failure(step, f"{expected} within {limit:.1f} s", got())

    def connect(self):
        def got():
            state = "the slave answers, but does not let us in" if self.answered else "no reply at all"
            return f"{state} ({self.trouble})" if self.trouble else state

        seconds = self.wait("connect", CONNECT_LIMIT, lambda: True, "Data_Exchange", got)
        say(f"Data_Exchange reached after {seconds:.2f} s")

    def pkw(self, step, job_id, pnu, reply_id, value=0):
        """Hold one job until the reply for its PNU is there; return the 32-bit value of the reply."""
        if pnu == self.job[0] & 0x7FF:
            # The reply to the last job would pass for the reply to this one: job 0 in between.
            self.set_job(0, 0)
            self.wait(step, REPLY_LIMIT, lambda: self.reply[0] == 0, "reply 0 to job 0", self._reply)
        expected = reply_id << 12 | pnu
        self.set_job(job_id << 12 | pnu, value)

        def replied():
            return self.reply[0] >> 12 and self.reply[0] & 0x7FF == pnu

        self.wait(step, REPLY_LIMIT, replied, f"{expected:04X}", self._reply)
        if self.reply[0] != expected:
            raise Failure(step, f"{expected:04X}", self._reply())
        say(f"{step}: job {self._telegram(self.job)}, reply {self._telegram(self.reply)}")
        return self.reply[2]

    def wait_for(self, step, pattern):
        """Exchange data until the status word shows a pattern of the manual."""
        name, mask, value = pattern
        self.wait(
            step,
            STATE_LIMIT,
            lambda: self.zsw & mask == value,
            f"{name} (ZSW & {mask:04X} = {value:04X})",
            lambda: f"ZSW {self.zsw:04X} (& {mask:04X} = {self.zsw & mask:04X})",
        )
        say(f"{step}: {name}, ZSW {self.zsw:04X}, position {self.hiw}")

    def check_freeze(self, step):
        """Freeze the inputs for a while of a travel, then release them: Global_Control reaches the drive."""
        self.master.freezeMode(GROUP)
        self.exchange_for(step, FREEZE_TIME)
        frozen = self.hiw
        self.exchange_for(step, FREEZE_TIME)
        if self.hiw != frozen:
            raise Failure(f"{step}, frozen", f"position {frozen} to stay", self.hiw)
        self.master.freezeModeCancel(GROUP)
        released = ("another position than the frozen", lambda: f"still {self.hiw}")
        self.wait(f"{step}, unfrozen", STATE_LIMIT, lambda: self.hiw != frozen, *released)
        say(f"{step}: Freeze held position {frozen}, Unfreeze showed {self.hiw}")

    def exchange_for(self, step, seconds):
        """Go on exchanging data for a while."""
        end = time.monotonic() + seconds
        self.wait(step, STATE_LIMIT, lambda: time.monotonic() >= end, "Data_Exchange to go on", lambda: "no reply")

    def travel(self, step, stw, target, window, freeze=False):
        """Start a travel job with an edge of STW.6 and wait for its end."""
        start = self.hiw
        acknowledge = self.zsw & JOB_ACKNOWLEDGED
        self.set_words(self.stw, target)
        self.wait_for(f"{step}, target set", READY_TO_TRAVEL)
        self.set_words(stw)
        self.wait_for(f"{step} from {start} to {target}, STW {stw:04X}", TRAVEL_JOB_ACTIVE)
        if self.zsw & JOB_ACKNOWLEDGED == acknowledge:
            raise Failure(step, "ZSW.12 toggled by the new job", f"ZSW {self.zsw:04X}")
        if freeze:
            self.check_freeze(step)

        def arrived():
            if self.zsw & FAULT:
                raise Failure(step, "no fault", f"ZSW {self.zsw:04X} at position {self.hiw}")
            return self.zsw & TARGET_REACHED and self.zsw & STANDS_STILL and abs(self.hiw - target) <= window

        seconds = self.wait(
            step,
            abs(target - start) / INCREMENTS_PER_SECOND + TRAVEL_LIMIT,
            arrived,
            f"ZSW.10 and ZSW.13 within {window} of {target}",
            lambda: f"ZSW {self.zsw:04X} at position {self.hiw}",
        )
        say(f"{step}: target position reached after {seconds:.2f} s, ZSW {self.zsw:04X}, position {self.hiw}")
        self.wait_for(f"{step}, afterwards", READY_TO_TRAVEL)

    def _reply(self):
        return self._telegram(self.reply)

    @staticmethod
    def _telegram(words):
        pke, ind, pwe = words
        return f"{pke:04X} {ind:04X} {pwe >> 16:04X} {pwe & 0xFFFF:04X}"


def play(drive, distance):
    """The whole play."""
    drive.connect()

    value = drive.pkw("read calibration value", READ, PNU_CALIBRATION_VALUE, VALUE_DOUBLE_WORD)
    say(f"calibration value is {value}")
    value = drive.pkw("write limit 1", WRITE_DOUBLE_WORD, PNU_LIMIT_1, VALUE_DOUBLE_WORD, 250_000)
    if value != 250_000:
        raise Failure("write limit 1", "250000 in the reply", value)
    value = drive.pkw("read limit 1 back", READ, PNU_LIMIT_1, VALUE_DOUBLE_WORD)
    if value != 250_000:
        raise Failure("read limit 1 back", 250_000, value)
    window = drive.pkw("read position window", READ, PNU_WINDOW, VALUE_WORD)
    drive.set_job(0, 0)

    drive.set_words(0x0000)
    drive.wait_for("STW 0000", READY_TO_RUN)
    drive.set_words(0x000B)
    drive.wait_for("enable operation, STW 000B", OPERATION_ENABLED)
    drive.set_words(0x003B, drive.hiw)
    drive.wait_for("prepare positioning, STW 003B", READY_TO_TRAVEL)
    home = drive.hiw
    say(f"start position {home}")
    drive.travel("first job", 0x007B, home + distance, window, freeze=True)
    drive.travel("second job", 0x003B, home, window)
    drive.set_words(0x0000)
    drive.wait_for("disable, STW 0000", READY_TO_RUN)


def short_play(drive):
    """Start-up, one job of the parameter channel, one state of the drive: enough to see that a master was served."""
    drive.connect()
    drive.pkw("read position window", READ, PNU_WINDOW, VALUE_WORD)
    drive.set_job(0, 0)
    drive.set_words(0x000B)
    drive.wait_for("enable operation, STW 000B", OPERATION_ENABLED)
    drive.set_words(0x0000)
    drive.wait_for("disable, STW 0000", READY_TO_RUN)


def out_of_time(_signal, _frame):
    raise Failure("whole play", f"an end within {TOTAL_LIMIT} s", "none")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--port", required=True, help="serial port or pseudo-terminal of the bus")
    parser.add_argument("--baud", required=True, type=int)
    parser.add_argument("--gsd", required=True)
    parser.add_argument("--address", type=int, default=5)
    parser.add_argument("--distance", type=int, default=1600, help="length of the first job in increments")
    parser.add_argument("--short", action="store_true", help="do not travel")
    parser.add_argument("--debug", type=int, default=0, help="pyprofibus: 1 states, 2 telegrams as well")
    arguments = parser.parse_args()

    signal.signal(signal.SIGALRM, out_of_time)
    signal.alarm(TOTAL_LIMIT)
    start = time.monotonic()
    try:
        drive = Drive(arguments.port, arguments.baud, arguments.gsd, arguments.address, arguments.debug)
    except ProfibusError as error:
        print(f"FAIL open: {' '.join(str(error).split())}", file=sys.stderr)
        return 1
    except termios.error as error:
        # pyprofibus opens every port at 9600 with even parity. A pseudo-terminal has no parity; Debian's C library then
        # reports EINVAL if nothing else was to change either, that is if the last master left it at 9600.
        print(f"FAIL open: {error}; on a pseudo-terminal try: stty -F {arguments.port} 38400", file=sys.stderr)
        return 1
    try:
        if arguments.short:
            short_play(drive)
        else:
            play(drive, arguments.distance)
    except Failure as failure:
        print(failure, file=sys.stderr)
        return 1
    finally:
        drive.close()
    seconds = time.monotonic() - start
    say(f"OK at {arguments.baud} bit/s: {drive.exchanges} exchanges in {seconds:.1f} s")
    return 0


if __name__ == "__main__":
    sys.exit(main())
