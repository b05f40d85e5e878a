"""The README says what is true: its Python example runs."""

import re
from pathlib import Path

README = Path(__file__).resolve().parents[2] / "README.md"


def test_the_python_example_runs(capsys):
    (example,) = re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), flags=re.DOTALL)
    assert len(example.splitlines()) <= 15
    exec(compile(example, str(README), "exec"), {})
    stroke, angle, energy = map(float, capsys.readouterr().out.split())
    assert abs(stroke - 0.02) < 1e-6
    assert 0.0 < angle < 1.0
    assert energy > 0.0


def test_every_file_it_names_is_there():
    text = README.read_text(encoding="utf-8")
    for name in re.findall(r"\]\(((?:docs/)?[\w./]+)\)", text):
        assert (README.parent / name).exists(), name
