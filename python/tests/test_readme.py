"""What the README shows is what runs."""

import os
import sys
from pathlib import Path

import pytest

from profidrive import Emulator

HERE = Path(__file__).parent
BLOCKS = [block.split("```")[0] for block in (HERE.parent / "README.md").read_text("utf-8").split("```python\n")[1:]]


def test_the_first_block_is_the_test_of_a_master() -> None:
    assert BLOCKS[0] == (HERE / "test_shaft.py").read_text("utf-8")
    assert len(BLOCKS[0].splitlines()) <= 25


def test_the_second_block_runs(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "examples").symlink_to(HERE.parents[1] / "examples")
    monkeypatch.chdir(tmp_path)
    exec(BLOCKS[1], {})
    assert capsys.readouterr().out.endswith("2 -> 5  FDL status: who is there?\n")


def test_the_block_of_the_projects_readme_runs(profibus_line: Emulator, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(Path(sys.executable).parent), prepend=os.pathsep)
    readme = (HERE.parents[1] / "README.md").read_text("utf-8")
    names: dict[str, object] = {}
    exec(readme.split("```python\n")[1].split("```")[0], names)
    test = names["test_a_blocked_shaft_is_fault_b"]
    assert callable(test)
    test(profibus_line)
