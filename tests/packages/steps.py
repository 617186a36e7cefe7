#!/usr/bin/env python3
"""shellcheck over the steps of workflows: steps.py SHELLCHECK FILE...; needs PyYAML."""

import re
import subprocess
import sys
from pathlib import Path

import yaml

shellcheck, *files = sys.argv[1:]
for file in files:
    for name, job in yaml.safe_load(Path(file).read_text())["jobs"].items():
        for step in job["steps"]:
            if "run" not in step:
                continue
            script = "set -eo pipefail\n" + re.sub(r"\$\{\{.*?\}\}", "EXPRESSION", step["run"])
            if subprocess.run([shellcheck, "--shell=bash", "-"], input=script, text=True).returncode != 0:
                sys.exit(f"{file}: job {name}, step {step.get('name')}")
