"""A scheme of one's own: extrapolate linearly from the last two samples, as first-order-hold does."""

import rimbench


class Line:
    def __init__(self, outputs):
        self.past = {side: [] for side in outputs}  # newest first: (time, outputs)

    def receive(self, side, sample):
        self.past[side] = [(sample.time, sample.y), *self.past[side][:1]]

    def input(self, side, at, own):
        (t0, y0), *older = self.past["actuator" if side == "mechanics" else "mechanics"]
        if not older:
            return y0
        ((t1, y1),) = older
        middle = at.since_exchange + at.length / 2  # the mean of a line is its value in the middle
        return [now + middle * ((now - before) / (t0 - t1)) for now, before in zip(y0, y1)]


scheme = rimbench.Scheme("line", Line, order=2, samples=2)

if __name__ == "__main__":
    for case in ("wedge-box", "bouncing-ball"):
        print(rimbench.simulate(case, scheme, 1e-3, duration_s=0.5))
