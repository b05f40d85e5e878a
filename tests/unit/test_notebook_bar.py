"""The progress bar in a notebook: one output that is replaced, and warnings that stay."""

import logging
import sys
from types import SimpleNamespace

import pytest

from weavesim.app.progress import ProgressBar
from weavesim.notebook import NotebookBar, in_notebook
from weavesim.run.frame import Outcome


class Display:
    """What IPython would show: every state of every output."""

    def __init__(self) -> None:
        self.outputs: list[list[str]] = []

    def __call__(self, html, display_id):
        assert display_id
        states = [html.data]
        self.outputs.append(states)
        return SimpleNamespace(update=lambda html: states.append(html.data))


@pytest.fixture
def shown(monkeypatch) -> Display:
    """A kernel without a kernel."""
    display = Display()
    html = lambda text: SimpleNamespace(data=text)  # noqa: E731
    shell = SimpleNamespace(kernel=object())
    monkeypatch.setitem(sys.modules, "IPython", SimpleNamespace(get_ipython=lambda: shell))
    monkeypatch.setitem(sys.modules, "IPython.display", SimpleNamespace(HTML=html, display=display))
    return display


def test_only_a_kernel_is_a_notebook(monkeypatch):
    monkeypatch.delitem(sys.modules, "IPython", raising=False)
    assert not in_notebook()
    for shell, expected in ((None, False), (SimpleNamespace(), False), (SimpleNamespace(kernel=None), False),
                            (SimpleNamespace(kernel=object()), True)):  # fmt: skip
        monkeypatch.setitem(sys.modules, "IPython", SimpleNamespace(get_ipython=lambda shell=shell: shell))
        assert in_notebook() == expected


def test_a_run_has_one_output_that_ends_full(shown, coarse_run, capsys):
    info, frames = coarse_run
    bar = ProgressBar()
    bar.start(info)
    for frame in frames:
        bar.frame(frame)
    logging.getLogger("weavesim").warning("the mesh is <coarse>")
    bar.finish(Outcome.FINISHED)
    (states,) = shown.outputs
    assert 'value="0.0000"' in states[0] and "preparing" in states[0]
    last = states[-1]
    assert 'value="1.0000"' in last and "100%" in last and "stroke 60.0 mm" in last
    assert "warning: the mesh is &lt;coarse&gt;" in last and "finished after" in last
    assert capsys.readouterr() == ("", "")  # nothing beside it
    # not at every frame: the run needs the cores
    assert len(states) < len(frames)


def test_a_share_beyond_its_ends_is_shown_at_the_end(shown):
    bar = NotebookBar("run")
    bar.update(1.2, "late")
    assert "100%" in shown.outputs[0][-1]


def test_a_real_kernel_shows_it(tmp_path):
    """In Jupyter itself, where it can be had: bar, table and picture."""
    nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    pytest.importorskip("ipykernel")
    from tests.support.paths import ROOT

    lines = (
        f"import sys; sys.path.insert(0, {str(ROOT)!r})",
        "from weavesim.notebook import NotebookBar, in_notebook",
        "assert in_notebook()",
        "bar = NotebookBar('run'); bar.update(0.5, 'half'); bar.line('a line'); bar.update(1.0, 'done')",
        "from weavesim.output.pictures.style import new_axes, new_figure",
        "figure = new_figure(3.0, 2.0); new_axes(figure, 1, 1, 1, title='chart'); figure",
    )
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell("\n".join(lines))])
    nbclient.NotebookClient(notebook, timeout=120, resources={"metadata": {"path": str(tmp_path)}}).execute()
    shown, picture = notebook.cells[0].outputs
    assert "done" in shown["data"]["text/html"] and "a line" in shown["data"]["text/html"]
    assert len(picture["data"]["image/png"]) > 1000
