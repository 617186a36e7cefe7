"""What the READMEs show is what runs."""

import os
from pathlib import Path

import pytest

from profidrive import binary

pytest_plugins = ["pytester"]

HERE = Path(__file__).parent
ROOT = HERE.parents[1]


def blocks(page: Path) -> list[str]:
    return [block.split("```")[0] for block in page.read_text("utf-8").split("```python\n")[1:]]


BLOCKS = blocks(ROOT / "python" / "README.md")


def test_the_first_block_is_the_test_of_a_master() -> None:
    assert BLOCKS[0] == (HERE / "test_shaft.py").read_text("utf-8")
    assert len(BLOCKS[0].splitlines()) <= 25


def test_the_second_block_runs(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    monkeypatch.chdir(tmp_path)
    exec(BLOCKS[1], {})
    assert capsys.readouterr().out.endswith("2 -> 5  FDL status request\n")


def test_the_test_in_the_readme_of_the_repository_passes(
    monkeypatch: pytest.MonkeyPatch, pytester: pytest.Pytester
) -> None:
    (block,) = (block for block in blocks(ROOT / "README.md") if "profibus_line" in block)
    monkeypatch.setenv("PATH", f"{binary().parent}{os.pathsep}{os.environ['PATH']}")
    pytester.makepyfile(block)
    pytester.runpytest_subprocess().assert_outcomes(passed=1)
