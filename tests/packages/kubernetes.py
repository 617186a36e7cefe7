#!/usr/bin/env python3
"""The Kubernetes example runs: what a schema cannot see, and each of its lines with this program.

    kubernetes.py PROFIDRIVE packages/kubernetes/lines.yaml      needs PyYAML
"""

import re
import signal
import subprocess
import sys
import tempfile
import tomllib
import urllib.request
from pathlib import Path

import yaml

program, example = sys.argv[1:]
objects = {thing["kind"]: thing for thing in yaml.safe_load_all(Path(example).read_text())}
stateful, service, policy = (objects[kind] for kind in ("StatefulSet", "Service", "NetworkPolicy"))
files = objects["ConfigMap"]["data"]
pod = stateful["spec"]["template"]
(container,) = pod["spec"]["containers"]
ports = {port["name"]: port["containerPort"] for port in container["ports"]}
mounts = {mount["name"]: mount["mountPath"] for mount in container["volumeMounts"]}
probes = [container[kind]["httpGet"] for kind in ("startupProbe", "readinessProbe", "livenessProbe")]

# Names that must be the same in several places.
labels = pod["metadata"]["labels"]
assert stateful["spec"]["selector"]["matchLabels"] == labels
assert service["spec"]["selector"] == labels
assert policy["spec"]["podSelector"]["matchLabels"] == labels
assert stateful["spec"]["serviceName"] == service["metadata"]["name"]
assert {port["targetPort"]: port["port"] for port in service["spec"]["ports"]} == ports
assert {port["port"] for rule in policy["spec"]["ingress"] for port in rule["ports"]} == set(ports)
assert {probe["port"] for probe in probes} <= set(ports)
assert pod["metadata"]["annotations"]["prometheus.io/port"] == str(ports["metrics"])
assert {claim["metadata"]["name"] for claim in stateful["spec"]["volumeClaimTemplates"]} <= set(mounts)
config = {volume["name"]: volume["configMap"]["name"] for volume in pod["spec"]["volumes"]}
assert config == {"lines": objects["ConfigMap"]["metadata"]["name"]}

# A file for each pod, and none too many; each says the ports of the container and keeps its state on the volume.
names = [f"{stateful['metadata']['name']}-{number}" for number in range(stateful["spec"]["replicas"])]
assert sorted(files) == [f"{name}.toml" for name in names], sorted(files)
with tempfile.TemporaryDirectory() as folder:
    for name in names:
        text = files[f"{name}.toml"]
        plant = tomllib.loads(text)
        (line,) = plant["line"]
        places = {"link": line["link"].removeprefix("tcp:"), "panel": line["panel"], "metrics": plant["metrics"]}
        assert places == {place: f"0.0.0.0:{port}" for place, port in ports.items()}, places
        assert line["state-dir"].startswith(mounts["state"] + "/")

        # The same file here: folders of the test, ports that are free.
        here = Path(folder, name)
        here.mkdir()
        text = text.replace(mounts["state"], str(here)).replace("0.0.0.0:", "127.0.0.1:")
        text = re.sub(r"127\.0\.0\.1:\d+", "127.0.0.1:0", text)
        Path(folder, f"{name}.toml").write_text(text)
        arguments = [argument.replace("$(POD)", name) for argument in container["args"]]
        assert arguments[-1] == f"{mounts['lines']}/{name}.toml"
        arguments[-1] = f"{folder}/{name}.toml"
        emulator = subprocess.Popen([program, *arguments], stdout=subprocess.PIPE, text=True)
        try:
            ready = dict(word.split("=", 1) for word in emulator.stdout.readline().split() if "=" in word)
            paths = {("panel", probe["path"]) for probe in probes}
            paths.add(("metrics", pod["metadata"]["annotations"]["prometheus.io/path"]))
            for place, path in sorted(paths):
                base = re.match(r"https?://[^/]+", ready[place])[0]
                with urllib.request.urlopen(base + path, timeout=5) as answer:
                    assert answer.status == 200 and answer.read(), path
        finally:
            emulator.send_signal(signal.SIGTERM)
        assert emulator.wait(10) == 0
        assert list(here.glob("eeproms/*.eeprom")) or "drive" not in line, "nothing was kept"
        print(f"{name}: {ready}; {len(paths)} paths answer")
