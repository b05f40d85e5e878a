"""Guards of energies."""

from tests.support.judged import said


def test_what_falls_may_lose_its_energy_to_damping():
    assert said("damping_loss", damping_loss_ratio=0.9, gravity_work_ratio=0.9) == []
    assert len(said("damping_loss", damping_loss_ratio=0.9, gravity_work_ratio=0.1)) == 1
