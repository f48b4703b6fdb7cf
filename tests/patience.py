"""How long a test waits for something that must happen: far longer than it takes on the busiest machine."""

import time

PATIENCE = 240
"""Wall time [s]. It ends what hangs, and is no measure of speed."""


def wait_until(true, process=None):
    """Wait until `true()` is; fail at once if `process`, which is to make it so, has ended."""
    deadline = time.monotonic() + PATIENCE
    while not true():
        assert process is None or process.poll() is None, process.communicate()[1]
        assert time.monotonic() < deadline
        time.sleep(0.01)
