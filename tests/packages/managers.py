#!/usr/bin/env python3
"""What packages/manifests writes installs a release: install.sh by running it, the others by their own rules.

    managers.py ARCHIVE.tgz     an archive that packages/archive made on this machine; needs PyYAML, and ruby for Homebrew
"""

import functools
import hashlib
import http.server
import json
import os
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import threading
import tomllib
from pathlib import Path

import yaml

archive = Path(sys.argv[1])
here = Path(__file__).resolve().parent
version = tomllib.loads(Path("Cargo.toml").read_text())["package"]["version"]
host = archive.name.removeprefix(f"profidrive-{version}-").removesuffix(".tgz")
REPOSITORY = "https://host.example/owner/profidrive"
RELEASE = f"{REPOSITORY}/releases/download/v{version}"
WINDOWS = "x86_64-pc-windows-msvc"
MACHINES = {
    ("macos", "arm"): "aarch64-apple-darwin",
    ("macos", "intel"): "x86_64-apple-darwin",
    ("linux", "arm"): "aarch64-unknown-linux-gnu",
    ("linux", "intel"): "x86_64-unknown-linux-gnu",
}


def name(target: str) -> str:
    return f"profidrive-{version}-{target}.{'zip' if 'windows' in target else 'tgz'}"


def sha256(target: str) -> str:
    return hashlib.sha256((folder / name(target)).read_bytes()).hexdigest()


class Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *_: object) -> None:
        pass


def install(prefix: Path, script: str | None = None, **environment: str) -> subprocess.CompletedProcess[str]:
    """Runs install.sh as `curl ... | sh` does."""
    server = f"http://127.0.0.1:{served.server_address[1]}"
    environment = {**os.environ, "PREFIX": str(prefix), "PROFIDRIVE_RELEASE": server, **environment}
    script = script if script is not None else (folder / "install.sh").read_text()
    return subprocess.run(["sh"], input=script, env=environment, capture_output=True, text=True, timeout=60)


def refused(prefix: Path, words: str, done: subprocess.CompletedProcess[str]) -> None:
    assert done.returncode == 1 and words in done.stderr, (words, done)
    assert not prefix.exists(), f"{prefix}: something was installed"


with tempfile.TemporaryDirectory() as work:
    folder = Path(work, "release")
    folder.mkdir()
    shutil.copy(archive, folder)
    missing = subprocess.run(["packages/manifests", REPOSITORY, folder], capture_output=True, text=True)
    assert missing.returncode == 1 and "there is no" in missing.stderr, missing
    # Of the others only the checksum counts here.
    for target in {*MACHINES.values(), WINDOWS} - {host}:
        (folder / name(target)).write_text(target)
    subprocess.run(["packages/manifests", REPOSITORY, folder], check=True)
    for file in folder.iterdir():
        if file.suffix not in (".tgz", ".zip"):
            assert not re.search("@[A-Z]", file.read_text()), f"{file.name} has an empty place"

    served = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Quiet, directory=str(folder)))
    threading.Thread(target=served.serve_forever, daemon=True).start()

    # install.sh: anew, and over what is there.
    prefix = Path(work, "own")
    for _ in range(2):
        done = install(prefix)
        assert done.returncode == 0 and f"installed: {prefix}/bin/profidrive {version}" in done.stdout, done
    told = subprocess.run([prefix / "bin/profidrive", "--version"], capture_output=True, text=True, check=True)
    assert version in told.stdout, told
    share = prefix / "share"
    for file in (
        share / "man/man1/profidrive-emulate.1",
        share / "bash-completion/completions/profidrive",
        share / "zsh/site-functions/_profidrive",
        share / "fish/vendor_completions.d/profidrive.fish",
    ):
        assert file.is_file(), file
    assert [file.name for file in (prefix / "bin").iterdir()] == ["profidrive"]

    # What must not install anything.
    none = Path(work, "none")
    whole = (folder / "install.sh").read_text()
    half = install(none, script=whole[: whole.rindex("main")])
    assert half.returncode == 0 and not none.exists(), half
    fake = Path(work, "fake")
    fake.mkdir()
    (fake / "uname").write_text("#!/bin/sh\necho Plan9\n")
    (fake / "uname").chmod(0o755)
    refused(none, "no built program for Plan9", install(none, PATH=f"{fake}:{os.environ['PATH']}"))
    octets = bytearray((folder / archive.name).read_bytes())
    octets[len(octets) // 2] ^= 1
    (folder / archive.name).write_bytes(octets)
    refused(none, "the checksum of", install(none))
    (folder / archive.name).unlink()
    refused(none, "cannot fetch", install(none))
    shutil.copy(archive, folder)
    print(f"install.sh installs {archive.name}, and nothing that is damaged")

    scoop = json.loads((folder / "profidrive.json").read_text())
    made = scoop["architecture"]["64bit"]
    assert (scoop["version"], scoop["bin"]) == (version, "profidrive.exe"), scoop
    assert (made["url"], made["hash"]) == (f"{RELEASE}/{name(WINDOWS)}", sha256(WINDOWS)), scoop
    assert made["extract_dir"] == name(WINDOWS).removesuffix(".zip"), scoop

    winget = [yaml.safe_load(file.read_text()) for file in sorted(folder.glob("*.yaml"))]
    assert {(row["PackageIdentifier"], row["PackageVersion"]) for row in winget} == {("Profidrive.Profidrive", version)}
    by_type = {row["ManifestType"]: row for row in winget}
    assert by_type.keys() == {"version", "installer", "defaultLocale"}, by_type.keys()
    installer = by_type["installer"]
    [machine] = installer["Installers"]
    assert machine["InstallerUrl"] == f"{RELEASE}/{name(WINDOWS)}", machine
    assert machine["InstallerSha256"] == sha256(WINDOWS), machine
    [nested] = installer["NestedInstallerFiles"]
    assert nested["RelativeFilePath"] == f"{name(WINDOWS).removesuffix('.zip')}\\profidrive.exe", nested
    assert by_type["version"]["DefaultLocale"] == by_type["defaultLocale"]["PackageLocale"]
    print("Scoop and winget: addresses, checksums and names are those of the archives")

    if not shutil.which("ruby"):
        print("!! NOT CHECKED: the formula of Homebrew; there is no ruby", file=sys.stderr)
    else:
        with tarfile.open(archive) as tar:
            tar.extractall(Path(work, "unpacked"), filter="data")
        [inside] = Path(work, "unpacked").iterdir()
        brewed = Path(work, "brewed")
        command = ["ruby", here / "formula.rb", folder / "profidrive.rb", inside, brewed]
        read = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True)
        wanted = {
            f"{system} {processor} {RELEASE}/{name(target)} {sha256(target)}"
            for (system, processor), target in MACHINES.items()
        }
        assert set(read.stdout.splitlines()) == wanted, read.stdout
        for file in ("bin/profidrive", "share/man/man1/profidrive-emulate.1", "etc/bash_completion.d/profidrive"):
            assert (brewed / file).is_file(), file
        print("Homebrew: the formula names each archive, and installs this one")
