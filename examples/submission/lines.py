"""Lets a class answer the line protocol: python3 lines.py MODULE:CLASS. A class that looks at `own` cannot be served so."""

import importlib
import json
import sys
from types import SimpleNamespace


def main():
    module, name = sys.argv[1].split(":")
    make = getattr(importlib.import_module(module), name)
    scheme, received = None, {}
    for line in sys.stdin:
        asked = json.loads(line)
        reply = {}
        if asked["ask"] == "hello":
            reply = {"protocol": "rimbench-line", "version": 1, "role": "scheme"}
        elif asked["ask"] == "begin":
            scheme = make({side: [name for name, _ in ports["outputs"]] for side, ports in asked["sides"].items()})
        elif asked["ask"] == "inputs":
            step = asked["step"]
            for side in ("mechanics", "actuator"):
                sample = asked[side]
                # Where the mechanics goes first, its sample of the end comes again with the next step.
                if received.get(side) != sample["time_s"]:
                    received[side] = sample["time_s"]
                    own = {"index": step["index"], "start": step["start_s"], "length": step["length_s"]}
                    scheme.receive(side, SimpleNamespace(time=sample["time_s"], y=sample["y"], **own))
            reply = {side: inputs(scheme, side, step) for side in ("mechanics", "actuator")}
        print(json.dumps({**reply, "id": asked["id"]}), flush=True)


def inputs(scheme, side, step):
    """What a side gets in each micro step of the actuator; said once where it is held."""
    count = step["actuator_steps"]
    length = step["length_s"] / count
    pieces = []
    for index in range(count):
        since = index * length
        start = step["start_s"] + since
        at = {"index": index, "count": count, "start": start, "middle": start + 0.5 * length}
        pieces.append(list(scheme.input(side, SimpleNamespace(**at, length=length, since_exchange=since), None)))
    if all(piece == pieces[0] for piece in pieces):
        return {"polynomials": [[value] for value in pieces[0]]}
    return {"pieces": pieces}


main()
