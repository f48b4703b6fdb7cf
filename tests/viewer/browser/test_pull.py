"""Bodies on joints in the page: pulled by the pointer, driven by sliders and keys."""

import pytest
from viewer.browser.chromium import BLIND, COARSE, HEIGHT, WIDTH, shown, until
from viewer.conftest import SMALL

from neve.scene.reading.load import scene_from, to_toml
from neve.viewer.show import prepare

GATE = {
    "shape": "box", "center": [0.2, 0.0, 1.2], "size": [0.2, 0.2, 0.6], "density": 300.0, "joint": "hinge",
    "axis": [0.0, 1.0, 0.0], "anchor": [0.2, 0.0, 1.5], "motor": {"kind": "torque", "target": 0.0},
}  # fmt: skip


def test_a_gate_is_pulled_and_its_motor_driven(page, tmp_path):
    """The move tool pulls it until it is let go; slider and keys hold its control, the button ends that."""
    path = tmp_path / "gate.toml"
    path.write_text(to_toml(scene_from(SMALL | {"bodies": [GATE]})), encoding="utf-8")
    server = prepare(str(path), out=str(tmp_path / "out"), threads=1)
    page.add_init_script(BLIND)
    with shown(server) as address:
        page.goto(address + COARSE)
        until(page, "() => neve.drawn > 0", "it is there")
        hand = server.player._sim.solver.placed.rigid.hand
        page.evaluate("() => { neve.panel.root.hidden = true; neve.tools.choose('move'); neve.redraw() }")
        until(page, "() => !neve.dirty", "it is drawn without the panel")
        x, y, _ = page.evaluate("() => neve.camera.project([0.2, -0.1, 1.0])")
        page.mouse.move(x * WIDTH, y * HEIGHT)
        page.mouse.down()
        until(page, "() => neve.pull.held?.last.name === 'bodies.0'", "the gate is held")
        assert page.evaluate("() => neve.pull.triangles().length") == 1
        page.mouse.move(x * WIDTH + 120, y * HEIGHT, steps=3)
        page.evaluate("() => neve.send({ do: 'frame' })")
        until(page, "() => neve.state.frame === 1", "a frame has passed")
        assert server.player._sim.solver.placed.rigid.poses()[0].position[0] > 0.2
        page.mouse.up()
        until(page, "() => neve.pull.held === null", "it is let go")
        page.evaluate("() => { neve.panel.root.hidden = false }")
        page.locator("[data-section='controls'] > summary").click()
        slider = page.locator("[aria-label='bodies.0'][type='range']")
        slider.evaluate("(e) => { e.value = '0.5'; e.dispatchEvent(new Event('input')) }")
        for _ in range(200):
            if not hand.springs and hand.controls:
                break
            page.wait_for_timeout(50)
        assert not hand.springs
        assert hand.controls["bodies.0"] == pytest.approx(0.5, abs=0.01)
        page.locator("#view").focus()
        page.keyboard.down("t")
        until(page, "() => Number(neve.drive.rows[0].slider.value) > 0.6", "the key raises it")
        page.keyboard.up("t")
        page.locator("[data-section='controls'] button", has_text="↺").click()
        for _ in range(200):
            if not hand.controls:
                break
            page.wait_for_timeout(50)
        assert not hand.controls
