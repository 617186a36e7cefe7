#!/usr/bin/env python3
"""A DP master in pyprofibus, to be judged by `profidrive judge`.

    judged_master.py PORT ADDRESS...       a master on the terminal PORT, with a station of 4 octets each way at each ADDRESS

    profidrive judge --link pty:/tmp/bus --station 5,ident=1234,cfg=2313,groups=01 --master 2 --watchdog 1000 --html report.html
    judged_master.py /tmp/bus 5

It runs until the terminal is gone or it is killed. pyprofibus raises DpError for RS in Data_Exchange; this program goes on then.
"""

import io
import pathlib
import sys
import termios
import time

from pyprofibus.conf import PbConf
from pyprofibus.util import ProfibusError

GSD = pathlib.Path(__file__).with_name("judged_io.gsd")


def configuration(port, addresses):
    """pyprofibus' own form. Sizes are seen from the slave: input_size is what the master sends."""
    text = f"[PROFIBUS]\ndebug=0\n[PHY]\ntype=serial\ndev={port}\nbaud=19200\n[DP]\nmaster_class=1\nmaster_addr=2\n"
    for number, address in enumerate(addresses):
        text += f"[SLAVE_{number}]\nname=io\naddr={address}\ngsd={GSD}\nsync_mode=0\nfreeze_mode=0\ngroup_mask=1\n"
        text += "watchdog_ms=1000\ninput_size=4\noutput_size=4\n"
    return PbConf(io.StringIO(text))


def main():
    port, *addresses = sys.argv[1:]
    conf = configuration(port, addresses)
    master = conf.makeDPM()
    slaves = [slave.makeDpSlaveDesc() for slave in conf.slaveConfs]
    for slave in slaves:
        master.addSlave(slave)
    master.initialize()
    count = 0
    while True:
        count = count % 255 + 1
        try:
            # pyprofibus exchanges data only with those that have new outputs.
            for slave in slaves:
                slave.setMasterOutData(bytearray([count] * 4))
            master.run()
        except ProfibusError as error:
            print(error, file=sys.stderr)
        except (OSError, termios.error):
            return  # the terminal is gone
        time.sleep(0.0003)


if __name__ == "__main__":
    main()
