"""Serve a flight on this machine, and fly it as a client of the network protocol.

    python network_client.py [OUTPUT.png]

For a drone that is served elsewhere, leave `LiveFlight` out and give `Client` its address.
"""

import sys

import matplotlib.pyplot as plt

import workbench as wb
from workbench.link import Client
from workbench.link.server.config import ServerConfig

plt.switch_backend("Agg")
plt.rcParams.update(wb.STYLE)

CORNERS = ((1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.0, 0.0))  # [m] from the start


def fly(address):
    """Fly from corner to corner, and return what the client saw: t, x, y (n, 3)."""
    seen, left = [], list(CORNERS)
    client = Client(address, name="square", topics=["position_data"])
    with client, client.control() as drone:
        start = None
        for sample in client:
            start = start or (sample["x"], sample["y"])
            x, y = sample["x"] - start[0], sample["y"] - start[1]
            seen.append((sample.time, x, y))
            if abs(left[0][0] - x) + abs(left[0][1] - y) < 0.1:
                left.pop(0)
                print(f"corner {len(CORNERS) - len(left)}: {x:.2f} {y:.2f} m, {sample.time:.1f} s")
            if not left:
                break
            drone.velocity(1.5 * (left[0][0] - x), 1.5 * (left[0][1] - y), 0.0)
    return seen


if __name__ == "__main__":  # the flight is a process of its own, which imports this file
    with wb.LiveFlight() as flight:
        flight.wait()
        path = fly(flight.serve(ServerConfig(port=0)).result())
    print(f"{len(path)} positions in {path[-1][0] - path[0][0]:.1f} s")

    figure, axes = plt.subplots(figsize=(5.6, 4.6), layout="constrained")
    time, x, y = zip(*path, strict=True)
    dots = axes.scatter(x, y, c=time, s=8)
    axes.plot(*zip(*CORNERS, strict=True), "r+", ms=12)
    axes.set(xlabel="x, east [m]", ylabel="y, north [m]", aspect="equal")
    axes.set_title("positions that the client received")
    figure.colorbar(dots, label="time [s]")
    figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "network_client.png")
