"""The surface look, and how many particles a picture takes."""

import numpy as np
from viewer.browser.chromium import changed_pixels, look, until

# Keeps how many points each picture of the snow has, in place of drawing them.
COUNT = """() => {
  window.pictures = [];
  WebGL2RenderingContext.prototype.drawArraysInstanced = (mode, first, count, instances) =>
    pictures.push({ count, instances, skip: neve.stage.skip, most: neve.stage.detail.most });
}"""
# A million particles, while something moves for ever.
MANY = """() => {
  const q = new Uint16Array(4e6);
  for (let i = 0; i < q.length; i++) q[i] = i % 4 < 3 ? (i * 40503) % 65535 : 0;  // dry
  Object.assign(neve.stage.detail, { most: 100000, wait: Infinity });
  neve.take({ ...neve.state, n: 1e6, q });
  pictures.length = 0;
  neve.redraw();
}"""
LEARNT = """() => {
  const d = neve.stage.detail;
  const learn = (clock, moved) => { d.moved = moved; d.learn(clock); return [d.most, d.wait]; };
  Object.assign(d, { most: 1e6, slow: 1, drawn: 1000, wait: 350 });
  return [learn(1100, 1050), learn(1110, 1110), learn(1310, 1300), learn(5000, 1400)];
}"""


def test_a_million_particles_stay_fluid(page, unseen):
    """No more are drawn in motion than there is time for; all when still; none below a pixel far away."""
    page.evaluate("() => neve.setQuality(0)")
    page.evaluate(COUNT)
    page.evaluate(MANY)
    until(page, "() => pictures.length > 0", "a picture on the way")
    moving = page.evaluate("() => pictures[0]")
    assert moving["skip"] == 10
    assert moving["count"] * moving["instances"] <= 100_000
    page.evaluate("() => { neve.stage.detail.wait = 0 }")
    until(page, "() => pictures.at(-1).skip === 1", "all is still, and drawn once more by itself")
    assert page.evaluate("() => [pictures.at(-1).count, pictures.at(-1).instances]") == [1_000_000, 1]
    page.evaluate("() => { neve.camera.distance = 1000; neve.dirty = true }")
    until(page, "() => pictures.at(-1).skip > 1", "it is far")
    spacing, focal = page.evaluate("() => [neve.scene.spacing, neve.camera.focal]")
    skip = page.evaluate("() => pictures.at(-1).skip")
    assert skip == min(31, int((1.2 * 1000 / (spacing * focal)) ** 3))


def test_pictures_that_take_long_leave_particles_out(page, unseen):
    """Past 40 ms a fifth fewer and a longer wait, below 22 ms a tenth more; a pause says nothing."""
    slow, fast, slower, paused = page.evaluate(LEARNT)
    assert np.allclose(slow, [0.8e6, 350.0])
    assert np.allclose(fast, [0.88e6, 350.0])
    assert np.allclose(slower, [0.704e6, 500.0])
    assert paused == slower


def test_snow_is_a_bright_surface(page, live):
    """It covers what the grains cover and is about as bright; hollows and grain leave their marks in it."""
    ground = look(page)
    grains = ground.min(axis=2) > 150
    page.evaluate("() => neve.setSurface(true)")
    until(page, "() => neve.stage.surface?.width > 0 && !neve.dirty", "it is drawn")
    surface = look(page)
    bright = surface.min(axis=2) > 150
    assert 0.75 < bright.sum() / grains.sum() < 1.25
    both = bright & grains
    assert surface[both].mean() > 0.9 * ground[both].mean()
    assert np.abs(np.diff(surface.mean(axis=2), axis=1))[both[:, 1:]].mean() > 0.5  # not one flat white
    assert changed_pixels(ground, surface) > 0.005
    page.evaluate("() => neve.setSurface(false)")
    assert changed_pixels(ground, look(page)) < 0.002


# All snow, every k-th particle of it, or (0) none is water.
FLOOD = """(k) => {
  const q = neve.state.q.slice();
  for (let i = 0; i < q.length; i += 4) q[i + 3] = k && (i / 4) % k === 0 ? 65535 : 0;
  neve.take({ ...neve.state, mode: "snow", q });
  neve.redraw();
  return [neve.stage.pool.count, neve.stage.snow.count, neve.state.n, neve.stage.water !== null];
}"""
EMPTY = """() => {
  window.full = neve.state;
  neve.take({ ...full, n: 0, q: new Uint16Array(0) });
  neve.redraw();
}"""


def test_water_that_stands_together_is_one_clear_surface(page, live):
    """A ball of it is smooth, bluer than snow, and shows what is behind; lone drops stay drops."""
    snow = look(page)
    page.evaluate(EMPTY)
    ball = (np.abs(snow - look(page)).max(axis=2) > 24) & (snow.min(axis=2) > 100)
    page.evaluate("() => neve.take(full)")
    pool, rest, count, _ = page.evaluate(FLOOD, 20)
    assert (pool, rest) == (0, count)
    pool, rest, count, _ = page.evaluate(FLOOD, 1)
    assert pool > 0.9 * count
    assert pool + rest == count
    water = look(page)
    assert (np.abs(water - snow).max(axis=2)[ball] > 40).mean() > 0.8
    assert np.median((water[..., 2] - water[..., 0])[ball]) > 10 + np.median(
        (snow[..., 2] - snow[..., 0])[ball]
    )
    rough = [np.abs(np.diff(seen.mean(axis=2), axis=1))[ball[:, 1:]].mean() for seen in (snow, water)]
    assert rough[1] < 0.7 * rough[0]
    page.evaluate("() => { for (const solid of neve.scene.solids) solid.visible = false; neve.redraw() }")
    assert (np.abs(look(page) - water).max(axis=2)[ball] > 12).mean() > 0.3


def test_snow_without_water_needs_nothing_of_it(page, live):
    """No programs and textures of water are made before there is some; none is drawn once it is gone."""
    snow = look(page)
    assert page.evaluate("() => neve.stage.water === null && neve.stage.pool.count === 0")
    assert page.evaluate(FLOOD, 1)[0] > 0
    look(page)
    pool, rest, count, made = page.evaluate(FLOOD, 0)
    assert (pool, rest, made) == (0, count, True)
    assert changed_pixels(snow, look(page)) < 0.002


# Three particles close to the camera; depth [m] and radius of its grain [m] of each pixel, raw and smoothed.
CHUNKS = """() => {
  const { stage, camera, state } = neve;
  const middle = [0, 1, 2].map((k) => state.low[k] + 32768 * state.step[k]);
  const far = Math.round((0.5 * neve.scene.spacing) / state.step[0]);
  const q = new Uint16Array(12).fill(32768);
  q[0] += far;
  q[5] += far;
  q[3] = q[7] = q[11] = 0;  // dry
  neve.setSurface(true);
  neve.take({ ...state, n: 3, mode: "snow", q });
  camera.target = middle;
  camera.distance = 2.5 * neve.scene.spacing;
  camera.update(stage.canvas.width, stage.canvas.height, 0);
  stage.draw(camera);
  const { gl, surface } = stage;
  const { width, height } = surface;
  const read = (frame) => {
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
    const data = new Float32Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.FLOAT, data);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    return Array.from(data);
  };
  return [width, height, camera.focal, read(surface.first), read(surface.layers[1].frame)];
}"""


def test_grains_close_up_are_chunks_with_faces_and_edges(page, live):
    """Depths bend nowhere on a face; on a ball of radius r they do so by s^2/r or more, of pixels s wide.

    The smoothing leaves them, and moves next to nothing, however far away what lies beyond an edge is.
    """
    width, height, focal, *layers = page.evaluate(CHUNKS)
    raw, smooth = (np.reshape(layer, (height, width, 4))[..., :2] for layer in layers)
    depth, r = raw[..., 0], raw[..., 1]
    one = depth > 0  # a grain covers the pixel and its neighbours
    for axis, by in ((0, 1), (0, -1), (1, 1), (1, -1)):
        one &= np.roll(r, by, axis) == r
    assert one.sum() > 1000
    s = depth[one] / focal
    for seen, share in ((depth, 0.5), (smooth[..., 0], 0.25)):  # a pixel beside an edge is smoothed
        bends = [np.roll(seen, 1, k) - 2 * seen + np.roll(seen, -1, k) for k in (0, 1)]
        flat = [np.abs(bend[one]) * r[one] / s**2 < 0.5 for bend in bends]
        assert np.mean(flat[0] & flat[1]) > share
    moved = np.abs(smooth[..., 0] - depth)[one] / r[one]
    assert np.quantile(moved, 0.99) < 0.05
