#!/usr/bin/env python3
"""Whether any dependency in Cargo.lock says that it needs a newer compiler than Cargo.toml promises (rust-version).

It proves no more than what crates say of themselves. `.ci/run` compiles with the promised compiler where rustup can
fetch it, and uses this where it cannot.
"""

import json
import subprocess
import sys


def version(text: str) -> tuple[int, ...]:
    return tuple(int(part) for part in (text.split(".") + ["0", "0"])[:3])


command = ["cargo", "metadata", "--format-version", "1", "--locked", "--all-features"]
packages = json.loads(subprocess.run(command, stdout=subprocess.PIPE, check=True).stdout)["packages"]
promised = next(p["rust_version"] for p in packages if p["name"] == "profidrive" and p["source"] is None)
newer = [p for p in packages if p["rust_version"] and version(p["rust_version"]) > version(promised)]
for package in newer:
    print(f"{package['name']} {package['version']} needs Rust {package['rust_version']}, promised is {promised}")
silent = sum(1 for package in packages if not package["rust_version"])
print(f"{len(packages)} crates, {silent} of them say nothing, {len(newer)} need more than Rust {promised}")
sys.exit(1 if newer else 0)
