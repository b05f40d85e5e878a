"""The damping in the table of what is known before a run."""

from tests.support.jobs import TRAY, write_tray
from weavesim import AtRest, Blank, Setup, Sheet, Stage, glass_polypropylene
from weavesim.job.advice.damping import release_damping, suggested_damping
from weavesim.job.advice.told import damping_rows
from weavesim.job.build import setup_of
from weavesim.job.read import read_job


def test_a_damping_is_suggested_with_its_reason(tmp_path):
    cases = (("100 1/s", "ok", ""), ("5 1/s", "look", "vibrations last for the"), ("9000 1/s", "look", "it holds back"))
    for given, judgement, words in cases:
        text = TRAY.replace("[output]", f'[process]\ndamping = "{given}"\n\n[output]')
        setup = setup_of(read_job(write_tray(tmp_path, text)))
        (row,) = damping_rows(setup)
        assert (row.topic, row.what, row.value, row.judgement) == ("damping", "of nodes", given, judgement)
        assert row.advice.startswith(words)
        assert f"suggested: {suggested_damping(setup.duration):g} 1/s, by which vibrations fall by e six" in row.advice


def test_every_damping_of_the_forming_stages_is_judged(tmp_path):
    stages = '[[stage]]\nname = "close"\n\n[[stage]]\nname = "hold"\nduration = "5 ms"\ndamping = "9000 1/s"\n\n'
    text = TRAY.replace("[output]", f'[process]\ndamping = "100 1/s"\n\n{stages}[output]')
    close, hold = damping_rows(setup_of(read_job(write_tray(tmp_path, text))))
    assert (close.what, close.value, close.judgement) == ("in close", "100 1/s", "ok")
    assert (hold.what, hold.value, hold.judgement) == ("in hold", "9000 1/s", "look")


def test_a_release_is_judged_by_the_whole_length():
    """Symmetry halves only the sides across its planes."""
    blank = Blank.rectangle((0.0, 0.0), (0.3, 0.05), 0.05)
    for planes, length in (((), 0.3), (("y",), 0.3), (("x",), 0.6), (("x", "y"), 0.6)):
        setup = Setup(
            "free", sheets=[Sheet(blank, glass_polypropylene())], symmetry=planes,
            stages=[Stage("free", 1.0, AtRest(1e-3, 1e-2))],
        )  # fmt: skip
        (row,) = damping_rows(setup)
        assert f"suggested: {release_damping(glass_polypropylene(), length):g} 1/s" in row.advice
