"""The damping in the table of what is known before a run."""

from tests.support.jobs import TRAY, write_tray
from weavesim.job.advice.damping import suggested_damping
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
