"""A real browser, headless, without a graphics card: how tests start it and look at its page.

The browser is the first of: the program that the variable NEVE_BROWSER names; the Chromium that
`playwright install chromium` has put there; a Chromium or Chrome of the system. Without Playwright or a
browser these tests are skipped.
"""

import asyncio
import contextlib
import io
import os
import shutil
import threading
from pathlib import Path

import numpy as np
from PIL import Image

# Draw with the processor: no machine of the tests needs a graphics card.
ARGUMENTS = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
if hasattr(os, "geteuid") and os.geteuid() == 0:
    ARGUMENTS.append("--no-sandbox")  # Chromium refuses its sandbox to root
WIDTH, HEIGHT = 760, 480
PATIENCE = 120_000  # ms: the processor draws a picture in a fraction of a second if others leave it one
# Before the page's own scripts: the graphics card draws nothing.
BLIND = """for (const name of ["drawArrays", "drawArraysInstanced", "drawElements"])
  WebGL2RenderingContext.prototype[name] = () => {};"""
COARSE = "#resolution=0.35"  # after a page's address: what is looked at is larger than its pixels


# The end of the gizmo's upward arrow, in JavaScript.
TIP = "(([x, y, z]) => [x, y, z + neve.gizmo.size([x, y, z])])(neve.gizmo.place())"


def program(chromium):
    """The browser to start; None if there is none."""
    named = os.environ.get("NEVE_BROWSER")
    own = Path(chromium.executable_path)
    system = (
        shutil.which(name)
        for name in ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
    )
    return named or (str(own) if own.is_file() else next((path for path in system if path), None))


@contextlib.contextmanager
def shown(server):
    """Serve in a thread; give the address."""
    loop, ready, told = asyncio.new_event_loop(), threading.Event(), {}

    async def main():
        async with server.serve(0) as socket:
            told["port"], told["end"] = socket.sockets[0].getsockname()[1], asyncio.Event()
            ready.set()
            await told["end"].wait()

    thread = threading.Thread(target=lambda: loop.run_until_complete(main()))
    thread.start()
    assert ready.wait(60)
    try:
        yield f"http://127.0.0.1:{told['port']}/"
    finally:
        loop.call_soon_threadsafe(told["end"].set)
        thread.join()
        loop.close()


def until(page, question, what):
    """Wait until JavaScript's `question` is true; the page's policy forbids the usual way, an eval."""
    for _ in range(PATIENCE // 100):
        if page.evaluate(question):
            return
        page.wait_for_timeout(100)
    raise AssertionError(f"waited in vain until {what}")


def drawn(page):
    """Wait until a picture later than now is drawn."""
    page.wait_for_selector("body[data-drawn]", state="attached")
    count = page.evaluate("() => +document.body.dataset.drawn")
    # Each question asks for a picture; the first that follows may have been under way before.
    ask = f"() => {{ neve.dirty = true; return +document.body.dataset.drawn > {count + 1} }}"
    until(page, ask, "the page draws")


def look(page):
    """What the canvas shows, (height, width, 3), without panel and bar."""
    drawn(page)
    image = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
    return np.asarray(image, np.int16)[90:380, 200:500]


def on_screen(page, point):
    """Where a point of the world, a JavaScript expression, is on the screen [px]."""
    x, y = page.evaluate(f"() => neve.camera.project({point}).slice(0, 2)")
    return x * WIDTH, y * HEIGHT


def changed_pixels(a, b):
    """Share of the pixels that differ clearly."""
    return float((np.abs(a - b).max(axis=2) > 24).mean())
