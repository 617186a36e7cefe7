import io, struct, time
from pathlib import Path

from pyprofibus.conf import PbConf

from profidrive import Emulator

GSD = Path(__file__).parents[2] / "gsd" / "SIKO0AC5.GSD"
CONF = """[PROFIBUS]\n[PHY]\ntype=serial\ndev={}\nbaud=19200\n[DP]\nmaster_class=1\nmaster_addr=2
[SLAVE_0]\naddr=5\ngsd={}\nwatchdog_ms=5000\ninput_size=14\noutput_size=14\n"""


def test_a_blocked_shaft_is_fault_b(profibus_line: Emulator) -> None:
    conf = PbConf(io.StringIO(CONF.format(profibus_line.link, GSD)))
    master, slave = conf.makeDPM(), conf.slaveConfs[0].makeDpSlaveDesc()
    master.addSlave(slave)
    master.initialize()
    drive, end = profibus_line.drives[5], time.monotonic() + 60
    while drive.fault is None and time.monotonic() < end:
        start = 0x0040 if time.monotonic() % 8 < 4 else 0  # each change starts a travel to 4000
        slave.setMasterOutData(struct.pack(">HHLHl", 0, 0, 0, 0x003B | start, 4000))
        master.run()
        drive.set_inputs(blocked=drive.position > 1000)
    assert drive.fault == "B", drive.why
