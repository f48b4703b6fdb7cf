"""Plots over time in the page."""

import csv

from viewer.browser.chromium import BLIND, COARSE, shown, until

from neve.viewer.show import prepare

PLACE = """() => {
  const { left, top, width } = document.querySelector(".chart").getBoundingClientRect();
  return [left, top, width];
}"""


def test_plots_follow_the_timeline(page, recorded):
    """Under the pointer the values of the curves are said, a click shows that moment, and all is saved."""
    page.add_init_script(BLIND)
    with shown(prepare(str(recorded))) as address:
        page.goto(address + COARSE)
        page.wait_for_selector("body[data-drawn]", state="attached")
        page.locator("[data-section='plots'] > summary").click()
        until(page, "() => neve.plots.rows.length === 6", "the figures are there")
        with (recorded / "log.csv").open() as file:
            log = list(csv.DictReader(file))
        until(page, "() => document.querySelector('.told')", "a chart is there")
        page.locator(".chart").first.scroll_into_view_if_needed()
        left, top, width = page.evaluate(PLACE)
        # The axes leave 46 px on the left and 7 on the right; the fourth of six rows is at 3/5.
        at = (left + 46 + 0.6 * (width - 53), top + 50)
        page.mouse.move(*at)
        said = f"kinetic {float(log[3]['kinetic']):.3g} J"
        until(page, f"() => document.querySelector('.told').textContent.includes('{said}')", said)
        page.mouse.click(*at)
        until(page, "() => neve.state.frame === 3", "that frame is shown")
        page.mouse.move(5, 5)
        page.locator(".timeline").fill("5")
        last = f"kinetic {float(log[5]['kinetic']):.3g} J"
        until(page, f"() => document.querySelector('.told').textContent.includes('{last}')", last)
        page.select_option("[aria-label='figure to plot']", "colliders.0 force_z")
        until(
            page, "() => neve.plots.charts.some((c) => c.unit === 'N')", "newtons have a chart of their own"
        )
        with page.expect_download() as download:
            page.locator("[data-section='plots'] button", has_text="CSV").click()
        with open(download.value.path()) as file:
            saved = list(csv.DictReader(file))
        assert [row["frame"] for row in saved] == [row["frame"] for row in log]
        assert [float(row["kinetic"]) for row in saved] == [float(row["kinetic"]) for row in log]
        assert saved[0]["colliders.0_force_z"] == ""
