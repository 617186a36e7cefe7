"""What the README shows is what runs."""

from pathlib import Path

import pytest

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
    assert capsys.readouterr().out.endswith("2 -> 5  FDL status request\n")
