import socket
import sys
from pathlib import Path
from urllib.request import ProxyHandler, build_opener

import pytest

from profidrive import ApiError, Emulator, ProfidriveError, decode

ROOT = Path(__file__).parents[2]
OWN_DRIVE = ROOT / "examples" / "own_drive.gsd"
FDL_STATUS = bytes.fromhex("10 05 02 49 50 16")


def ask(emulator: Emulator, octets: bytes, count: int) -> bytes:
    """Sends a telegram on a TCP line, and reads so many octets of the reply."""
    host, port = emulator.link.removeprefix("tcp:").rsplit(":", 1)
    with socket.create_connection((host, int(port)), timeout=10) as line:
        line.sendall(octets)
        reply = b""
        while len(reply) < count:
            reply += line.recv(count - len(reply))
        return reply


def test_drives_and_stations_are_objects() -> None:
    with Emulator(drives=[5, "6,gear=24"], stations=[f"7,gsd={OWN_DRIVE}"]) as emulator:
        assert list(emulator.drives) == [5, 6]
        assert list(emulator.stations) == [7]
        drive = emulator.drives[6]
        assert drive.device == "ag03-1" and "gear 24:1" in drive.state["product"]
        assert "ready-to-turn-on" in drive.zsw
        assert "operation-enabled" not in drive.zsw
        with pytest.raises(KeyError):
            assert "redy" in drive.zsw
        assert drive.stw.value == 0
        assert "no master exchanges data" in drive.why
        assert drive.parameter(1004) == 30
        drive.set_parameter(1004, 40)
        assert drive.parameter(1004) == 40
        station = emulator.stations[7]
        assert station.state["process"][0]["name"] == "Slot 1: PPO 1"
        station.set_input(1, 0, "unsigned8", 17)
        assert station.input(1, 0, "unsigned8") == 17
        assert station.output(1, 0, "unsigned8") == 0
        station.release_input(1, 0, "unsigned8")
        assert station.input(1, 0, "unsigned8") == 0


def test_a_refusal_says_why_and_changes_nothing() -> None:
    with Emulator() as emulator:
        drive = emulator.drives[5]
        with pytest.raises(ApiError, match="60") as refusal:
            drive.set_inputs(output_supply_volts=400.0)
        assert refusal.value.status in (400, 422)
        assert drive.inputs["output_supply_volts"] == 24.0
        drive.provoke("G")
        assert drive.wait_for_fault() == "G"
        assert [fault["fault"] for fault in drive.state["faults"] if fault["provoked"]] == ["G"]
        drive.provoke("G", provoked=False)
        assert not any(fault["present"] for fault in drive.state["faults"])
        drive.reset_inputs()
        with pytest.raises(TimeoutError, match="no master exchanges data"):
            drive.wait_until(lambda drive: drive.position > 0, timeout=0.1)


def test_faults_on_the_line_end_with_their_block() -> None:
    with Emulator(link="tcp:127.0.0.1:0") as emulator:
        with emulator.inject("wrong-fcs,station=5") as fault:
            wrong = ask(emulator, FDL_STATUS, 6)
            assert fault.injected == 1
        right = ask(emulator, FDL_STATUS, 6)
        assert right == bytes.fromhex("10 02 05 00 07 16")
        assert wrong != right
        fault.remove()


def test_events_are_an_iterator_and_the_capture_is_explained(tmp_path: Path) -> None:
    with Emulator(link="tcp:127.0.0.1:0", capture=tmp_path / "line.pcapng") as emulator:
        with emulator.events("telegram") as events:
            ask(emulator, FDL_STATUS, 6)
            heard, sent = next(events), next(events)
        assert (heard.octets, heard.data["direction"]) == (FDL_STATUS, "heard")
        assert "here, a slave" in sent.text
        assert [telegram.octets for telegram in emulator.telegrams()] == [heard.octets, sent.octets]


def test_a_line_file_says_everything(tmp_path: Path) -> None:
    file = tmp_path / "line.toml"
    line = '[[line]]\nlink = "tcp:127.0.0.1:0"\npanel = "127.0.0.1:0"\n[[line.drive]]\naddress = {}\n'
    file.write_text(line.format(5) + line.format(9))
    with Emulator(line=file) as emulator:
        assert [list(line.drives) for line in emulator.lines] == [[5], [9]]
        assert emulator.drives[5].position == 0
        assert emulator.lines[emulator.name] is emulator
        assert emulator.lines[1].drives[9].state["address"] == 9
        with pytest.raises(KeyError, match="there is no line 'cellar'"):
            emulator.lines["cellar"]
    written_otherwise = line.format(5).replace("[[line]]", "# no [[line]] but this one\n[[ line ]]", 1)
    file.write_text(written_otherwise + line.format(9))
    with Emulator(line=file, timeout=20) as emulator:
        assert [list(line.drives) for line in emulator.lines] == [[5], [9]]
    file.write_text("[[line")
    with pytest.raises(ProfidriveError, match="line.toml"), Emulator(line=file):
        pass
    with pytest.raises(ValueError, match="line file says everything"):
        Emulator(drives=[5], line=file)


def test_metrics_are_an_option() -> None:
    with Emulator(options=["--metrics", "127.0.0.1:0"]) as emulator:
        assert emulator.link.startswith(("/dev/pts/", "tcp:")) and emulator.panel
        assert emulator.metrics is not None
        with build_opener(ProxyHandler({})).open(emulator.metrics, timeout=10) as answer:
            assert answer.read().rstrip().endswith(b"# EOF")


def test_nodes_are_drives() -> None:
    with Emulator(nodes=[5, "6,device=ap10", "7,device=asda-a2"]) as emulator:
        drive, indicator, servo = emulator.drives.values()
        assert [node.device for node in emulator.drives.values()] == ["ag03-1", "ap10", "asda-a2"]
        assert [node.bus_state for node in emulator.drives.values()] == ["PRE-OPERATIONAL"] * 3
        assert "voltage-enabled" in drive.zsw and drive.stw.value == 0
        assert (drive.position, drive.velocity, drive.fault) == (0, 0, None)
        assert "PRE-OPERATIONAL" in drive.why
        with pytest.raises(KeyError, match="has no word 'ssw'; it has 6040, 6041"):
            assert drive.ssw
        assert drive.read_object(0x1000) == 0x192
        indicator.write_object(0x1017, 250)
        assert indicator.read_object(0x1017) == 250
        with pytest.raises(ApiError, match="there is no object 9999h"):
            drive.read_object(0x9999)
        indicator.set_inputs(shaft_revolutions=2.5)
        assert indicator.inputs["shaft_revolutions"] == 2.5
        indicator.key("star")
        assert {"key": "star", "pressed": True} in [
            {"key": key["key"], "pressed": key["pressed"]} for key in indicator.state["keys"]
        ]
        indicator.key("star", pressed=False)
        servo.provoke("011")
        assert "011" in servo.wait_for_fault()
        servo.power(False)
        assert servo.bus_state is None and servo.state["power"] == "off"
        added = emulator.add(8, "ap10")
        assert added.bus_state == "PRE-OPERATIONAL"
        added.unplug()
        with pytest.raises(ApiError, match="address 8"):
            assert added.state


def test_a_drive_of_the_profile_is_a_drive() -> None:
    table = ROOT / "examples" / "ppo_drive.toml"
    with Emulator(options=["--ppo-drive", f"7,parameters={table}"], drives=[5]) as emulator:
        drive = emulator.drives[7]
        assert drive.device == "ppo-drive" and drive.velocity == 0
        assert drive.parameter(2) == 20
        drive.set_parameter(30, -7, subindex=2)
        assert drive.parameter(30, 2) == -7
        drive.set_inputs(fault_number=77)
        assert drive.wait_for_fault() == "77"
        assert "a fault" in drive.why


def test_records_and_alarms_of_a_station_of_dp_v1(tmp_path: Path) -> None:
    gsd = tmp_path / "v1.gsd"
    gsd.write_text(
        "#Profibus_DP\nIdent_Number=0x1234\nDPV1_Slave=1\nMax_Diag_Data_Len=60\nC1_Read_Write_supp=1\n"
        "C1_Max_Data_Len=240\nProcess_Alarm_supp=1\nMax_User_Prm_Data_Len=3\n"
        'Ext_User_Prm_Data_Const(0)=0x80,0x40,0x00\nModule="io" 0x31\nEndModule\n'
    )
    records = tmp_path / "records.toml"
    records.write_text('[[record]]\nslot = 1\nindex = 10\ndata = "01 02"\n')
    with Emulator(link="tcp:127.0.0.1:0", stations=[f"7,gsd={gsd},records={records}"]) as emulator:
        station = emulator.stations[7]
        assert station.records == {(1, 10): b"\x01\x02"}
        station.set_record(1, 10, b"AB")
        assert station.records[1, 10] == b"AB"
        with pytest.raises(ApiError, match="expected 2"):
            station.set_record(1, 10, b"A")
        with pytest.raises(ApiError, match="not in data exchange"):
            station.raise_alarm("process", 1)
        with pytest.raises(ApiError, match="not in data exchange"):
            station.send_status(1)
        assert station.acyclic["ms1"]["open"] is False
        ask(emulator, bytes.fromhex("68 0F 0F 68 87 82 6D 3D 3E 80 01 01 0B 12 34 00 80 40 00 84 16"), 1)
        ask(emulator, bytes.fromhex("68 06 06 68 87 82 5D 3E 3E 31 13 16"), 1)
        assert station.acyclic["ms1"] == {"open": True, "owner": 2, "busy": False}
        raised = station.raise_alarm("process", 1, specifier="appears", data=b"P")
        assert (raised["type"], raised["state"], raised["data"]) == (2, "pending", "50")
        assert station.alarms == [raised]
        station.forget_alarms()
        assert station.alarms == []
        station.send_status(1, 1, data=b"x")


def test_what_cannot_start_says_why() -> None:
    with pytest.raises(ProfidriveError, match="two drives|address 5"), Emulator(drives=[5, 5]):
        pass
    with pytest.raises(ProfidriveError, match="was not ready|no-such"), Emulator(stations=["7,gsd=no-such.gsd"]):
        pass


@pytest.mark.skipif(sys.platform == "win32", reason="there are no pseudo-terminals")
def test_the_process_ends_with_its_block(tmp_path: Path) -> None:
    # A name of its own: the number of a terminal may be another emulator's at once.
    emulator = Emulator(link=f"pty:{tmp_path / 'bus'}")
    with emulator:
        assert Path(emulator.link).exists()
    assert not Path(emulator.link).exists()
    assert any("ended by a signal" in line for line in emulator.log)


def test_who_is_not_there_is_said() -> None:
    with Emulator(drives=["5"]) as emulator:
        drive = emulator.drives[5]
        with pytest.raises(KeyError, match="no station at address 6; there are 5"):
            emulator.drives[6]
    with pytest.raises(ApiError, match="has the emulator ended") as said:
        drive.key("up")
    assert said.value.status == 0


def test_telegrams_are_explained() -> None:
    request, reply = decode([FDL_STATUS, "10 02 05 00 07 16"])
    assert "FDL status request" in request.summary
    assert (reply.mark, reply.octets[0]) == ("plain", 0x10)
    assert [field.name for field in request.fields][:3] == ["SD1", "DA", "SA"]
    (broken,) = decode("10 05 02 49 51 16")
    assert broken.mark == "invalid"


def test_objects_of_a_node_from_its_file_are_set() -> None:
    sheet = Path(__file__).parents[2] / "tests" / "eds" / "pump.eds"
    with Emulator(nodes=[f"5,eds={sheet}"]) as emulator:
        node = emulator.drives[5]
        for value in (1.5, -0.25):
            node.set_inputs(**{"2001h": value})
            assert node.read_object(0x2001) == value
        node.reset_inputs()
        assert node.inputs["2001h"] == 1.5


def test_an_object_of_a_node_from_its_file_follows_a_signal() -> None:
    sheets = ROOT / "tests" / "eds"
    count = {"object": "2002h", "behaviour": "count", "from": 0, "to": 100_000, "every": "10ms"}
    with Emulator(nodes=[5], options=["--panel-files", str(sheets)]) as emulator:
        node = emulator.add(6, "eds-node", eds="pump.eds", profile="none", value=[count])
        first = node.read_object(0x2002)
        node.wait_until(lambda node: node.read_object(0x2002) > first + 5)
        assert node.inputs["2002h"] > first + 5
