"""Other scenes and runs in the page: the list, the address, files that are dropped."""

import shutil

from viewer.browser.chromium import BLIND, COARSE, shown, until

from neve.viewer.show import prepare

TETRAHEDRON = "v 0 0 0\\nv 0.2 0 0\\nv 0 0.4 0\\nv 0 0 0.6\\nf 1 3 2\\nf 1 2 4\\nf 1 4 3\\nf 2 3 4\\n"
GRID = "ncols 3\nnrows 3\nxllcorner 0\nyllcorner 0\ncellsize 0.5\n0 0 0\n0 0.4 0\n0 0 0\n"
DROP = """([name, text]) => {
  const carried = new DataTransfer();
  carried.items.add(new File([text], name));
  window.dispatchEvent(new DragEvent("drop", { dataTransfer: carried, cancelable: true }));
}"""

FOLDER = """() => {
  const folder = { name: "a_folder", size: 4096, arrayBuffer: () => Promise.reject(new Error("a folder")) };
  const event = new Event("drop", { cancelable: true });
  window.dispatchEvent(Object.assign(event, { dataTransfer: { files: [folder] } }));
}"""


def test_the_page_says_that_heat_runs_faster(page, small, tmp_path):
    """What films say of a scene stands on the page, and goes when it is no longer so."""
    small.write_text(small.read_text() + "\n[heat]\nheat_speed = 50.0\n")
    page.add_init_script(BLIND)
    server = prepare(str(small), out=str(tmp_path / "out" / "live"), threads=1)
    with shown(server) as address:
        page.goto(address + COARSE)
        until(page, "() => neve.scene && neve.state", "the scene is there")
        assert page.inner_text("#caption") == "heat x 50 real time"
        page.evaluate("() => neve.send({do: 'set', path: 'heat.heat_speed', value: 1.0})")
        until(page, "() => document.getElementById('caption').hidden", "nothing is to be said")


def test_another_run_by_list_and_address_and_dropped_files(page, small, finished, tmp_path):
    """`#scene=` opens a run, the list a scene; a wrong name is refused; a dropped mesh is set down."""
    shutil.copytree(finished, tmp_path / "a_run")
    page.add_init_script(BLIND)
    server = prepare(str(small), out=str(tmp_path / "out" / "live"), threads=1)
    with shown(server) as address:
        page.goto(f"{address}{COARSE}&scene=a_run")
        until(page, "() => neve.scene?.name === 'a_run' && neve.state", "the run of the address is shown")
        assert not page.evaluate("() => neve.scene.live")
        page.focus("#scene-choice")
        until(page, "() => neve.library.entries.length === 2", "the list is there")
        page.select_option("#scene-choice", "small.toml")
        until(page, "() => neve.scene.name === 'small.toml' && neve.scene.live", "the scene is played")
        until(page, "() => location.hash.includes('scene=small.toml')", "the address names it")
        page.evaluate("() => { location.hash = '#scene=../secret' }")
        until(
            page,
            "() => document.getElementById('notes').textContent.includes('nor in the served')",
            "it is refused",
        )
        page.evaluate(DROP, ["tetra.obj", TETRAHEDRON.replace("\\n", chr(10))])
        until(
            page, "() => neve.placing.ghost?.what.shape === 'mesh:tetra.obj'", "a ghost of the mesh is there"
        )
        page.keyboard.press("Enter")
        until(page, "() => neve.scene.solids.length === 3", "the mesh is set down")
        page.evaluate("() => { neve.drop.kind = 'sources' }")  # as with shift: ground is no snow
        page.evaluate(DROP, ["hill.asc", GRID])
        until(
            page, "() => neve.placing.ghost?.what.shape === 'terrain:hill.asc'", "a ghost of the map is there"
        )
        assert page.evaluate("() => neve.placing.ghost.kind") == "colliders"
        # Three heights 0.5 m apart, a hill of 0.4 m.
        assert (
            page.evaluate("() => neve.placing.ghost.what.half.map((n) => n.toFixed(3)).join()")
            == "0.500,0.500,0.200"
        )
        page.keyboard.press("Enter")
        until(page, "() => neve.scene.solids.length === 4", "the ground is set down")
        page.evaluate(DROP, ["picture.gif", "GIF89a"])
        until(
            page,
            "() => document.getElementById('notes').textContent.includes('picture.gif')",
            "it is refused",
        )
        page.evaluate(FOLDER)
        until(
            page, "() => document.getElementById('notes').textContent.includes('no folder')", "it is refused"
        )
