"""A browser, an empty page in it, and a page of a live session."""

import contextlib

import pytest
from viewer.browser.chromium import ARGUMENTS, BLIND, COARSE, HEIGHT, PATIENCE, WIDTH, drawn, program, shown

from neve.viewer.show import prepare


@pytest.fixture(scope="module")
def browser():
    playwright = pytest.importorskip(
        "playwright.sync_api", reason="playwright is not installed: pip install '.[test]'"
    )
    with playwright.sync_playwright() as p:
        path = program(p.chromium)
        if path is None:
            pytest.skip("no browser was found: run `playwright install chromium`, or set NEVE_BROWSER")
        try:
            started = p.chromium.launch(executable_path=path, args=ARGUMENTS)
        except playwright.Error:  # on a busy machine Chromium now and then ends while it starts: once more
            started = p.chromium.launch(executable_path=path, args=ARGUMENTS)
        yield started
        started.close()


@pytest.fixture
def page(browser):
    """An empty page that collects what the console says; errors fail the test."""
    context = browser.new_context(viewport={"width": WIDTH, "height": HEIGHT})
    page = context.new_page()
    page.set_default_timeout(PATIENCE)
    said = []
    page.on("console", lambda message: said.append(message.text) if message.type == "error" else None)
    page.on("pageerror", lambda error: said.append(str(error)))
    yield page
    assert said == []
    context.close()


@pytest.fixture
def live(page, small, tmp_path):
    """The page of a live session, paused at the start."""
    with _paused(page, small, tmp_path) as server:
        yield server


@pytest.fixture
def unseen(page, small, tmp_path):
    """The same where no picture is looked at: the page does all but draw, which the processor is slow at."""
    page.add_init_script(BLIND)
    with _paused(page, small, tmp_path) as server:
        yield server


@contextlib.contextmanager
def _paused(page, small, tmp_path):
    server = prepare(str(small), out=str(tmp_path / "out"), threads=1)
    with shown(server) as address:
        page.goto(address + COARSE)
        drawn(page)
        page.evaluate("() => neve.send({do: 'speed', factor: 100})")
        yield server
