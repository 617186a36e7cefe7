"""examples/ros2_canopen/bus.yml as far as it can be checked without ROS: its collection of nodes is written out as
ros2_canopen does, and dcfgen of Lely CANopen makes the master and what it writes to each drive.

    ros2_bus.py PROFIDRIVE
"""

import pathlib
import subprocess
import sys
import tempfile

import yaml

program = sys.argv[1]
example = pathlib.Path(__file__).parents[2] / "examples/ros2_canopen/bus.yml"
bus = yaml.safe_load(example.read_text())
defaults, nodes = bus.pop("defaults"), bus.pop("nodes")
bus |= {name: defaults | node for name, node in nodes.items()}
with tempfile.TemporaryDirectory() as folder:
    out = pathlib.Path(folder)
    sheet = subprocess.run([program, "eds", "asda-a2"], check=True, capture_output=True).stdout
    (out / "asda-a2.eds").write_bytes(sheet)
    (out / "bus.yml").write_text(yaml.safe_dump(bus))
    dcfgen = pathlib.Path(sys.executable).with_name("dcfgen")
    subprocess.run([dcfgen, "-r", "bus.yml"], check=True, cwd=out)
    made = {path.name for path in out.iterdir()} - {"asda-a2.eds", "bus.yml"}
    expected = {"master.dcf"} | {f"{name}.bin" for name in nodes}
    if made != expected or not all((out / name).stat().st_size for name in made):
        sys.exit(f"FAIL dcfgen made {sorted(made)}, expected {sorted(expected)}")
print("ok   dcfgen takes the bus of ros2_canopen")
