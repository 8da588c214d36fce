class Side:
    def __init__(self, file, needs, starts, inputs, outputs, unit, begin):
        self.libraries = [ctypes.CDLL(library, mode=ctypes.RTLD_GLOBAL) for library in needs]
        of, self.unit, self.begin, self.file = read_model_description(file), unit, begin, file
        two = of.fmiVersion.startswith("2")
        self.taken, self.inputs, self.a, self.b = (list(column) for column in zip(*inputs))
        self.outputs, self.c, self.d = (list(column) for column in zip(*outputs))
        self.fmu = (fmi2.FMU2Slave if two else fmi3.FMU3Slave)(
            guid=of.guid, unzipDirectory=extract(file), modelIdentifier=of.coSimulation.modelIdentifier, instanceName="side")
        times = dict(startTime=begin, stopTime=begin + STOP / unit); self.fmu.instantiate()
        for kind, reference, values in starts: getattr(self.fmu, "set" + kind)([reference], values)
        if two: self.fmu.setupExperiment(**times)
        self.fmu.enterInitializationMode(**({} if two else times))
        self.set, self.get = (getattr(self.fmu, name + ("Real" if two else "Float64")) for name in ("set", "get"))
    def read(self, u):
        self.set(self.inputs, list((u[self.taken] - self.b) / self.a))
        return np.array(self.get(self.outputs)) * self.c + self.d
    def step(self, time, u, h):
        self.set(self.inputs, list((u[self.taken] - self.b) / self.a)); self.fmu.doStep(self.begin + time / self.unit, h / self.unit)
def begun():
    mechanics, actuator, force = Side(*MECHANICS), Side(*ACTUATOR), np.zeros(len(ACTUATOR[4]))
    for rounds in range(1000):
        force, before = actuator.read(mechanics.read(force)), force
        if np.allclose(force, before, rtol=1e-9, atol=0): break
    assert rounds < 999, "both sides do not agree where they begin"
    mechanics.fmu.exitInitializationMode()
    actuator.read(mechanics.read(force)); actuator.fmu.exitInitializationMode()
    return mechanics, actuator, force
division = lambda length, longest: max(1, math.ceil(length / longest * (1 - 1e-9)))
# ---
mean = lambda sent, start, end: sent[0][1]
# ---
def mean(sent, start, end):
    slopes = [(p[1] - q[1]) / (p[0] - q[0]) for p, q in zip(sent, sent[1:])] or [0.0]
    bend = (slopes[0] - slopes[1]) / (sent[0][0] - sent[2][0]) if len(sent) > 2 else 0.0
    at = lambda t: sent[0][1] + (slopes[0] + bend * (t - sent[min(1, len(sent) - 1)][0])) * (t - sent[0][0])
    return (at(start) + 4 * at((start + end) / 2) + at(end)) / 6
# ---
def coupled():
    (mechanics, actuator, force), sent_m, sent_a, rows = begun(), [], [], []
    times = [0.0] + [(k - 1 + PHASE) * H for k in range(1, COUNT)] + [END]
    for k, t in enumerate(times):
        motion = mechanics.read(force); force = actuator.read(motion)
        rows.append((t, *force))
        if k == COUNT: return np.array(rows)
        sent_m, sent_a = [(t, motion)] + KEPT, [(t, force)] + sent_a[:DEGREE]
        length = H if (k or PHASE == 1) and k < COUNT - 1 else times[k + 1] - t
# ---
def reference():
    (mechanics, actuator, force), h, rows = begun(), REFERENCE_STEP, []
    for k in range(REFERENCE_STEPS + 1):
        motion = mechanics.read(force)
        if k: actuator.step((k - 1) * h, motion, h)
        force = actuator.read(motion)
        if k % REFERENCE_EVERY == 0 or k == REFERENCE_STEPS: rows.append((k * h, *force))
        if k < REFERENCE_STEPS: mechanics.step(k * h, force, h)
    return np.array(rows)
def between(t, x, y):  # of the cubics through four rows that cover t the middle one, or one beside it that is far smoother
    k = int(np.clip(np.searchsorted(x, t, "right") - 1, 0, len(x) - 2))
    cubics = ((i, np.polyfit(x[i:i + 4] - t, y[i:i + 4], 3)) for i in (k - 1, k - 2, k) if 0 <= i <= len(x) - 4)
    return min((abs(own[0]) * (0.25 if i == k - 1 else 1), own[-1]) for i, own in cubics)[1]
run, fine = coupled(), reference()
off = [run[:, row] - [between(t, fine[:, 0], fine[:, row]) for t in run[:, 0]] for row in range(1, run.shape[1])]
error = max(math.sqrt(np.mean(own ** 2)) / abs(fine[:, row + 1]).max() for row, own in enumerate(off))
