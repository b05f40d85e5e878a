"""An observer that keeps what it is given."""

from weavesim.run.frame import Frame, Outcome, RunInfo


class Frames:
    """An observer that keeps all frames."""

    def __init__(self) -> None:
        self.all: list[Frame] = []

    def start(self, info: RunInfo) -> None:
        self.all.clear()

    def frame(self, frame: Frame) -> None:
        self.all.append(frame)

    def finish(self, outcome: Outcome) -> None:
        self.outcome = outcome
