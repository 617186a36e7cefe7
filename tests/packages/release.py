#!/usr/bin/env python3
"""The release workflow makes what `cargo binstall` looks for, for the five targets.

    release.py ARCHIVE.tgz      an archive that packages/archive made on this machine; needs PyYAML
"""

import subprocess
import sys
import tarfile
import tomllib
from pathlib import Path

import yaml

TARGETS = {
    "x86_64-unknown-linux-gnu",
    "aarch64-unknown-linux-gnu",
    "x86_64-pc-windows-msvc",
    "x86_64-apple-darwin",
    "aarch64-apple-darwin",
}
archive = Path(sys.argv[1])
package = tomllib.loads(Path("Cargo.toml").read_text())["package"]
binstall = package["metadata"]["binstall"]
workflow = yaml.safe_load(Path(".github/workflows/release.yml").read_text())
build = workflow["jobs"]["build"]
steps = [step.get("run", "") for job in workflow["jobs"].values() for step in job["steps"]]


def wanted(target: str) -> tuple[str, str]:
    """The file that binstall fetches for a target, and where the program is in it."""
    rules = binstall | binstall.get("overrides", {}).get(target, {})
    values = {
        "repo": "REPOSITORY",
        "name": package["name"],
        "version": package["version"],
        "target": target,
        "archive-suffix": {"tgz": ".tgz", "zip": ".zip"}[rules["pkg-fmt"]],
        "bin": "profidrive",
        "binary-ext": ".exe" if "windows" in target else "",
    }
    filled = []
    for text in (rules["pkg-url"], rules["bin-dir"]):
        for key, value in values.items():
            text = text.replace(f"{{ {key} }}", value)
        assert "{" not in text, text
        filled.append(text)
    return filled[0], filled[1]


def made(target: str) -> tuple[str, str]:
    """The same as packages/archive names them: its lines, run for this target up to the names."""
    script = Path("packages/archive").read_text()
    begin, end = script.index("target="), script.index('cd "$target"')
    names = script[begin:end] + '\necho "$archive $folder/$program"'
    output = subprocess.run(["bash", "-euc", names, "archive", target], stdout=subprocess.PIPE, text=True, check=True)
    name, place = output.stdout.split()
    return name, place


matrix = {row["target"]: row["os"] for row in build["strategy"]["matrix"]["include"]}
assert set(matrix) == TARGETS, matrix
assert "packages/archive" in " ".join(steps) and 'gh release create "$GITHUB_REF_NAME"' in " ".join(steps)
assert workflow[True]["push"]["tags"] == ["v[0-9]*"]  # YAML reads the key `on` as true
for target in sorted(TARGETS):
    url, place = wanted(target)
    name, program = made(target)
    assert url == f"REPOSITORY/releases/download/v{package['version']}/{name}", (url, name)
    assert place == program, (place, program)
    print(f"{matrix[target]:18} {name}")

windows = made("x86_64-pc-windows-msvc")[0].replace(package["version"], "VERSION")
assert windows in Path("README.md").read_text(), f"the README tells technicians to download {windows}"

# And of this machine's, what is in it.
host = archive.name.removeprefix(f"{package['name']}-{package['version']}-").removesuffix(".tgz")
assert archive.name == made(host)[0]
with tarfile.open(archive) as tar:
    members = {member.name: member for member in tar.getmembers()}
assert members[made(host)[1]].mode & 0o111, "the program in the archive can be run"
for inside in ("README.md", "LICENSE-MIT", "LICENSE-APACHE", "man/profidrive-emulate.1", "completions/profidrive.bash"):
    assert f"{archive.name.removesuffix('.tgz')}/{inside}" in members, inside
