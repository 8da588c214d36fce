"""One side of a case or a coupling scheme, an object of Python, driven through the socket that is the standard input; process.rs says how."""

import copy, hashlib, importlib.util, itertools, json, os, site, socket, struct, sys, traceback
from types import SimpleNamespace

OUTPUTS, STEP, RATES, MODEL, OBSERVE, WORK, COPY, DROP, BEGIN, HEARD, DESCRIBE, RECEIVE, ANSWER = range(1, 14)
SIDES = ("mechanics", "actuator")
FORMS = ("polynomial", "inputs", "input")
TOUCHING = 1e-9


def main():
    link = socket.socket(fileno=os.dup(0))
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    stream = link.makefile("rb")

    def read(count):
        data = stream.read(count)
        if len(data) < count:
            os._exit(0)  # whoever asked has gone
        return data

    def to_number(value):
        # A text is none, as little as it is one for a class in a notebook.
        if isinstance(value, (str, bytes, bytearray)):
            raise TypeError(f"{value!r} instead of a number")
        return float(value)

    def numbers(values):
        values = [to_number(value) for value in values]
        return struct.pack(f"<BQ{len(values)}d", 0, len(values), *values)

    def refusal(error):
        place = [at for at in traceback.extract_tb(error.__traceback__) if at.filename != "<string>"][-1:]
        where = "".join(f" ({os.path.basename(at.filename)}, line {at.lineno}, in {at.name})" for at in place)
        try:
            said = str(error)
        except Exception:
            said = "without words"
        text = f"{type(error).__name__}: {said}{where}".replace("\n", "; ").encode(errors="backslashreplace")
        return struct.pack("<BQ", 1, len(text)) + text

    plan = json.loads(read(struct.unpack("<Q", read(8))[0]))
    own = os.path.dirname(os.path.abspath(plan["file"]))
    opened = set()

    def note(event, arguments):
        # A name that is opened to be read, while the side is made.
        if event == "open" and isinstance(arguments[0], (str, bytes, os.PathLike)) and not arguments[2] & 3:
            opened.add(os.path.abspath(os.fsdecode(arguments[0])))

    def made_of(side):
        """Digest of what the side is made of besides its file: what it says, modules of its own, and files that it has read so far."""
        said = getattr(side, "made_from", None)
        listed = [] if said is None or isinstance(said, str) else [os.path.join(own, os.fspath(path)) for path in said]
        modules = {os.path.abspath(module.__file__) for module in list(sys.modules.values()) if getattr(module, "__file__", None)}
        system = [sys.prefix, sys.base_prefix, os.path.dirname(os.__file__), *site.getsitepackages(), site.getusersitepackages()]
        system = [os.path.join(os.path.realpath(folder), "") for folder in (*system, "/etc", "/proc", "/sys", "/dev")]

        def is_own(path):
            inside = os.path.realpath(path)
            here = inside.startswith(os.path.join(os.path.realpath(own), ""))
            elsewhere = inside.startswith(tuple(system)) or any(part.startswith(".") for part in inside.split(os.sep))
            return os.path.isfile(path) and not path.endswith(".pyc") and (here or not elsewhere)

        files = {path for path in opened | modules if is_own(path)} - {os.path.abspath(plan["file"])}
        parts = []
        for path in files.union(listed):
            with open(path, "rb") as file:
                parts.append(f"{os.path.basename(path)} {hashlib.sha256(file.read()).hexdigest()}")
        parts = sorted(parts) + ([said] if isinstance(said, str) else [])
        return hashlib.sha256("\n".join(parts).encode(errors="backslashreplace")).hexdigest()[:16] if parts else ""

    try:
        sys.addaudithook(note)
        sys.path.insert(0, own)
        spec = importlib.util.spec_from_file_location("side", plan["file"])
        if spec is None:
            raise ImportError("is no file of Python: its name does not end in .py")
        module = importlib.util.module_from_spec(spec)
        sys.modules["side"] = module
        spec.loader.exec_module(module)
        made = getattr(module, plan["class"])
        if (run := plan.get("scheme", False)) is False:
            copies, needed = {0: made(plan["parameters"])}, ("outputs", "step")
        else:
            form = next((form for form in FORMS if hasattr(made, form)), "input")
            copies, needed = {0: made({side: tuple(run[side]) for side in SIDES}) if run else made}, ("receive", form)
        for name in needed:
            if not callable(getattr(copies[0], name, None)):
                others = ", `polynomial` or `inputs`" if name == "input" else ""
                raise TypeError(f"class {plan['class']} has no method `{name}`{others}")
    except BaseException as error:
        link.sendall(refusal(error))
        return
    link.sendall(b"\0")
    outputs, inputs = plan["outputs"], plan["inputs"]

    def checked(values, count, what):
        try:
            values = [to_number(value) for value in values]
        except TypeError as error:
            raise TypeError(f"{what} gives {values!r}: {error}") from None
        if len(values) != count:
            raise ValueError(f"{what} gives {len(values)} numbers instead of {count}")
        return values

    def flattened(values, count, what):
        values = values.ravel() if hasattr(values, "ravel") else values
        return checked([item for row in values for item in (row if hasattr(row, "__len__") else (row,))], count, what)

    def rows_of_engine(side):
        return int(getattr(side, "engine_rows", None) or 0)

    def model_of(side, h):
        model = side.interface_model(h)
        engine = rows_of_engine(side)
        contacts = len(model["compliance"]) if engine else int(getattr(side, "contacts", 0) or 0)
        n = contacts + inputs

        def part(name, count):
            return flattened(model[name], count, f"interface_model: `{name}`")

        gap = part("gap", contacts) if contacts else []
        if engine:
            of_rows = [part(name, contacts) for name in ("compliance", "damping", "stiffness")]
            of_rows.append(part("opposite", contacts) if "opposite" in model else range(contacts))
            head = [contacts, model.get("steps", 1), bool(model.get("symmetric", True))]
            parts = [head, part("H", n * n), part("a", n), part("w", n), part("position", inputs), gap, *of_rows]
            return [number for part in parts for number in part]
        closed = model.get("closed")
        closed = [gap <= TOUCHING for gap in gap] if closed is None else [bool(value) for value in closed]
        gamma, e = (to_number(getattr(side, name, 0.0) or 0.0) for name in ("stabilisation", "restitution"))
        parts = part("H", n * n) + part("a", n) + part("w", n) + part("position", inputs) + gap + [0.0] * contacts
        return parts + checked(closed, contacts, "interface_model: `closed`") + [gamma, e, 0.0, 0.0]

    def sample_of(values):
        time, index, start, length, count, *rest = values
        y, rest = tuple(rest[: int(count)]), iter(rest[int(count) :])
        sample = SimpleNamespace(time=time, y=y, index=int(index), start=start, length=length, model=None)
        if run["model"] is not None and (step := next(rest, None)) is not None:
            sample.model = {"mechanics_step": step}
            for name, extents in run["model"]:
                key = {"at_bound": "closed"}.get(name[4:], name[4:])
                sample.model[key] = shaped(rest, extents) if extents else next(rest)
        return sample

    def shaped(numbers, extents):
        """So many of the numbers, as an array where there is NumPy."""
        rows = extents[0]
        part = [shaped(numbers, extents[1:]) for _ in range(rows)] if extents[1:] else list(itertools.islice(numbers, rows))
        try:
            import numpy
        except ImportError:
            return part
        return numpy.array(part)

    def given(side, u):
        """Inputs as the side takes them."""
        return shaped(iter(u), [len(u)]) if getattr(side, "takes_arrays", False) else tuple(u)

    def flat(values):
        """The number of rows, 0 of plain numbers, and the numbers one after the other."""
        rows = [list(row) if hasattr(row, "__iter__") and not isinstance(row, (str, bytes)) else row for row in values]
        nested = {len(row) if isinstance(row, list) else None for row in rows}
        if len(nested) > 1:
            raise ValueError(f"{form} gives rows that are not alike")
        return [0.0 if nested <= {None} else float(len(rows))] + [to_number(number) for row in rows for number in (row if isinstance(row, list) else (row,))]

    def scheme_answers(scheme, what, values):
        if what == DESCRIBE:
            order, samples = (int(getattr(scheme, name, 1)) for name in ("order", "samples"))
            if min(order, samples) < 0:
                raise ValueError(f"order = {order}, samples = {samples}; valid: whole numbers from 0")
            model = float(bool(getattr(scheme, "interface_model", False)))
            return [float(FORMS.index(form)), float(order), float(samples), model, *made_of(scheme).encode()]
        side, *values = values
        side = SIDES[int(side)]
        if what == RECEIVE:
            scheme.receive(side, sample_of(values))
            return []
        index, count, length, start, *rest = values
        since, own = rest[0] if rest else 0.0, tuple(rest[1:])
        times = dict(length=length, start=start, middle=start + 0.5 * length, since_exchange=since)
        at = SimpleNamespace(index=int(index), count=int(count), **times)
        return flat(scheme.input(side, at, own) if form == "input" else getattr(scheme, form)(side, at))

    def answer(what, number, values):
        if what == DROP:
            copies.pop(number, None)
            return []
        side = copies[number]
        if run is not False and what in (DESCRIBE, RECEIVE, ANSWER):
            return scheme_answers(side, what, values)
        if what == OUTPUTS:
            return checked(side.outputs(given(side, values)), outputs, "outputs")
        if what == STEP:
            t, h, *u = values
            u = given(side, u)
            told = side.step(t, u, h)
            return checked(side.outputs(u) if told is None else told, outputs, "step")
        if what == RATES:
            t, *u = values
            gains = outputs * inputs
            rates = {"rate_gain": [0.0] * gains, **side.output_rates(t, given(side, u))}
            parts = (("rate", outputs), ("feedthrough", gains), ("rate_gain", gains))
            return [number for name, count in parts for number in flattened(rates[name], count, f"output_rates: `{name}`")]
        if what == MODEL:
            return model_of(side, values[0])
        if what == OBSERVE:
            names = getattr(side, "observables", ())
            return checked(side.observe(), len(names), "observe") if names else []
        if what == WORK:
            return [side.interface_work()]
        if what == COPY:
            free = max(copies) + 1
            copies[free] = copy.deepcopy(side)
            return [free]
        if what == DESCRIBE:
            through = getattr(side, "direct_feedthrough", None)
            known = [-1.0 if through is None else float(bool(through))]
            refused = getattr(side, "no_interface_model", None)
            known += [float(getattr(side, name, None) is not None) for name in ("interface_work", "interface_model", "output_rates")]
            known[2] *= not refused
            engine = rows_of_engine(side)
            known += [float(engine > 0), to_number(getattr(side, "model_from_s", 0.0))]
            # Behind the names, why there is no interface model, and what it is made of.
            names = "\n".join(getattr(side, "observables", ()) or ())
            names += "\0" + (refused or "") + "\0" + made_of(side)
            return known + [float(engine or getattr(side, "contacts", 0) or 0), *names.encode(errors="backslashreplace")]
        return [0.0] if what == HEARD else []

    while True:
        what, number = struct.unpack("<BI", read(5))
        if (what, number) == (0, 0):
            return
        (count,) = struct.unpack("<Q", read(8))
        values = struct.unpack(f"<{count}d", read(8 * count))
        try:
            said = numbers(answer(what, number, values))
        except BaseException as error:
            said = refusal(error)
        link.sendall(said)


main()
