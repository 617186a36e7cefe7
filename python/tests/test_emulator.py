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
        assert drive.state["gear_ratio"] == 24
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
        assert station.state["modules"][0]["name"] == "PPO 1"
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
        assert drive.inputs != {} and drive.state["faults"]["provoked"] + drive.state["faults"]["causes"]
        drive.reset_inputs()


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
    file = tmp_path / "plant.toml"
    line = '[[line]]\nlink = "tcp:127.0.0.1:0"\npanel = "127.0.0.1:0"\n[[line.drive]]\naddress = {}\n'
    file.write_text(line.format(5) + line.format(9))
    with Emulator(line=file) as emulator:
        assert [list(line.drives) for line in emulator.lines] == [[5], [9]]
        assert emulator.drives[5].position == 0
    written_otherwise = line.format(5).replace("[[line]]", "# no [[line]] but this one\n[[ line ]]", 1)
    file.write_text(written_otherwise + line.format(9))
    with Emulator(line=file, timeout=20) as emulator:
        assert [list(line.drives) for line in emulator.lines] == [[5], [9]]
    file.write_text("[[line")
    with pytest.raises(ProfidriveError, match="plant.toml"), Emulator(line=file):
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
    with Emulator(nodes=["5,device=ap10"]) as emulator:
        assert emulator.drives[5].state["device"] == "ap10"


def test_what_cannot_start_says_why() -> None:
    with pytest.raises(ProfidriveError, match="two drives|address 5"), Emulator(drives=[5, 5]):
        pass
    with pytest.raises(ProfidriveError, match="was not ready|no-such"), Emulator(stations=["7,gsd=no-such.gsd"]):
        pass


@pytest.mark.skipif(sys.platform == "win32", reason="there are no pseudo-terminals")
def test_the_process_ends_with_its_block() -> None:
    emulator = Emulator()
    with emulator:
        assert Path(emulator.link).exists()
    assert not Path(emulator.link).exists()
    assert any("ended by a signal" in line for line in emulator.log)


def test_telegrams_are_explained() -> None:
    request, reply = decode([FDL_STATUS, "10 02 05 00 07 16"])
    assert "FDL status request" in request.summary
    assert (reply.mark, reply.octets[0]) == ("plain", 0x10)
    assert [field.name for field in request.fields][:3] == ["SD1", "DA", "SA"]
    (broken,) = decode("10 05 02 49 51 16")
    assert broken.mark == "invalid"
