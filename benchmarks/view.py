"""Measure how many states per second `neve view` brings to its pages, without a browser.

    python benchmarks/view.py [PARTICLES]... [--pages N] [--seconds S] [--scene SCENE]
        [--threads N] [--from T]

Without --scene a player that costs nothing cycles through a few snapshots of snow, 120 a second: what is
measured is the server alone (encoding, sending, the pages' answers). With --scene the scene is simulated as
fast as it goes on the threads that are left, which is what a player sees; --from: after T seconds of it.
Pages are processes of their own that read every state and answer for it. Prints a table: states a second of
the slowest page, MB/s to it, the processors that the server's process kept busy, and seconds of the scene
that passed in a second.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import multiprocessing
import time

import numpy as np

from neve.viewer.players.player import Player
from neve.viewer.players.snapshot import Snapshot
from neve.viewer.show import prepare


class Cycling(Player):
    """Show the same few snapshots again and again."""

    live = True

    def __init__(self, particles: int) -> None:
        from neve.scene.reading.load import load

        super().__init__("cycling", load("throw_ball"))
        rng = np.random.default_rng(0)
        x = rng.random((particles, 3), dtype=np.float32) * 4
        values = rng.random(particles, dtype=np.float32)
        self._snapshots = [Snapshot(x + 0.01 * k, {"speed": values}, (), 0.1 * k, k) for k in range(4)]
        self._next = 0

    def solids(self):
        return ()

    def color_modes(self):
        return ["snow", "speed"]

    def state(self):
        return {"playing": True, "speed": 1.0, "frames": 0, "recording": False, "recorded": 0}

    def _begin(self):
        self._show(self._snapshots[0])

    def _busy(self):
        return True

    def _go_on(self):
        self._next += 1
        self._show(self._snapshots[self._next % len(self._snapshots)])
        time.sleep(1 / 120)

    def _do(self, command):
        pass


def page(port: int, mode: str, seconds: float, ready, answers) -> None:
    """Read states for so long, and put how many came a second and how many bytes."""
    from websockets.asyncio.client import connect

    async def read():
        async with connect(f"ws://127.0.0.1:{port}/socket", max_size=None, compression=None) as line:
            await line.send(json.dumps({"do": "color_mode", "mode": mode}))
            await line.send(json.dumps({"do": "speed", "factor": 100}))
            await line.send(json.dumps({"do": "play"}))
            count = total = seen = 0
            began = None
            while began is None or time.perf_counter() - began < seconds:
                message = await line.recv()
                if isinstance(message, str):
                    continue
                seen += 1
                await line.send(json.dumps({"do": "acknowledge", "version": seen}))
                if began is None and seen >= 3 and ready.is_set():  # the first come while processes start
                    began = time.perf_counter()
                    answers.put(None)
                elif began is not None:
                    count, total = count + 1, total + len(message)
            passed = time.perf_counter() - began
            answers.put((count / passed, total / passed / 1e6))

    asyncio.run(read())


def measure(server, pages: int, seconds: float, start: float) -> tuple[float, float, float, float]:
    """Return states a second and MB/s of the slowest page, the processors that the server took, and its pace.

    start: time of the scene from which to measure [s].
    """
    context = multiprocessing.get_context("spawn")
    answers, ready = context.Queue(), context.Event()

    async def main():
        async with server.serve(0) as socket:
            port = socket.sockets[0].getsockname()[1]
            readers = [
                context.Process(target=page, args=(port, ("snow", "speed")[i % 2], seconds, ready, answers))
                for i in range(pages)
            ]
            for reader in readers:
                reader.start()
            while server.player.latest is None or server.player.latest.time < start:
                await asyncio.sleep(0.01)
            ready.set()
            for _ in readers:
                await asyncio.to_thread(answers.get)
            began, spent, shown = time.perf_counter(), time.process_time(), server.player.latest.time
            found = [await asyncio.to_thread(answers.get) for _ in readers]
            passed = time.perf_counter() - began
            share, pace = (time.process_time() - spent) / passed, (server.player.latest.time - shown) / passed
            for reader in readers:
                await asyncio.to_thread(reader.join)
            return (*min(found), share, pace)

    return asyncio.run(main())


def main() -> None:
    raw = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=raw)
    parser.add_argument("particles", nargs="*", type=int, default=[100_000, 1_000_000])
    parser.add_argument("--pages", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=5.0)
    parser.add_argument("--scene", help="simulate this scene instead")
    parser.add_argument("--threads", type=int, default=None)
    parser.add_argument("--from", dest="start", type=float, default=0.0, help="time of the scene [s]")
    asked = parser.parse_args()
    print(f"{'particles':>10} {'pages':>5} {'states/s':>8} {'MB/s':>6} {'processors':>10} {'pace':>6}")
    for particles in asked.particles if asked.scene is None else [0]:
        if asked.scene is None:
            server = prepare("throw_ball")
            server.player = Cycling(particles)
            server.player.modes = {"speed"}
        else:
            server = prepare(asked.scene, threads=asked.threads)
        start = asked.start if asked.scene else 0.0
        rate, megabytes, share, pace = measure(server, asked.pages, asked.seconds, start)
        count = len(server.player.latest.x)
        print(f"{count:>10,} {asked.pages:>5} {rate:>8.1f} {megabytes:>6.0f} {share:>10.2f} {pace:>6.2f}")


if __name__ == "__main__":
    main()
