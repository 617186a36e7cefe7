"""Nodes of python-canopen and durand, judged: the rows that fail are those of docs/judged-devices.md.

    judged.py PROFIDRIVE

Exit status 0 if they are, and 1 with a line that begins with FAIL if they are not.
"""

import json
import pathlib
import subprocess
import sys
import tempfile

PROFIDRIVE = sys.argv[1]
HERE = pathlib.Path(__file__).parent
COMPLETE = HERE.parent / "eds/complete.eds"
NODE = "5"
ROWS = "N-K02,N-K06,N-O0*,N-O1*,N-X14,N-X19,N-M03,N-M04,N-Y15,N-Y4*"
EXPECTED = {
    "canopen": "N-K06 N-M03 N-M04 N-O02 N-O09 N-O10 N-O11 N-O12 N-X14 N-X19 N-Y15 N-Y41 N-Y42 N-Y43",
    "durand": "N-O12 N-X14 N-Y15 N-Y41 N-Y42 N-Y43 N-Y45",
}


def judged(kind, folder):
    """The rows that fail."""
    link, report, eds = (str(folder / name) for name in ("can0", f"{kind}.json", f"{kind}.eds"))
    program = [sys.executable, str(HERE / "judged_node.py"), kind]
    if kind == "durand":
        subprocess.run([*program, "-", NODE, eds], check=True)
    else:
        eds = str(COMPLETE)
    judge = [PROFIDRIVE, "judge", "--node", f"{NODE},eds={eds}", "--link", f"slcan-pty:{link}"]
    options = ["--write", "--moves-allowed", "--only", ROWS, "--json", report]
    with subprocess.Popen([*judge, *options], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as process:
        if not process.stdout.readline().startswith("ready "):
            sys.exit(f"FAIL {kind}: the judge is not ready")
        node = subprocess.Popen([*program, link, NODE, eds], stderr=subprocess.DEVNULL)
        try:
            process.communicate(timeout=180)
        finally:
            node.kill()
            node.wait()
    rows = json.loads(pathlib.Path(report).read_text())["rows"]
    return " ".join(sorted(row["id"] for row in rows if row["verdict"] == "fail"))


with tempfile.TemporaryDirectory() as place:
    for kind, expected in EXPECTED.items():
        failed = judged(kind, pathlib.Path(place))
        if failed != expected:
            sys.exit(f"FAIL a node of {kind}: {failed} fail, expected {expected}")
        print(f"ok the judge finds in a node of {kind}: {failed}")
