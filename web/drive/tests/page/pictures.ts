/**
 * What pictures of the demo have, in numbers. Each is run in the page, as `page.evaluate` does: it may use nothing of
 * this file.
 */
import type {} from "./demo_visit";

/**
 * Mean brightness (0..255) of the ground before the camera with powder, packed snow and ice everywhere, where no car
 * has been: before the first gate of the course.
 */
export const TONES = () => {
  const demo = window.neveDrive!;
  demo.toCourse();
  demo.drive(2, {});
  const copy = Object.assign(document.createElement("canvas"), { width: 32, height: 20 });
  const pen = copy.getContext("2d", { willReadFrequently: true })!;
  const tones = (["powder", "packed", "ice"] as const).map((type) => {
    demo.settings.type = type;
    demo.changed("type");
    demo.stage.render(demo.camera);
    pen.drawImage(document.querySelector("canvas")!, 0, 0, 32, 20);
    // The lowest quarter, without the middle where the car is.
    const rows = [0, 20].map((left) => pen.getImageData(left, 15, 12, 5).data);
    const green = rows.flatMap((data) => Array.from(data).filter((_, k) => k % 4 === 1));
    return green.reduce((sum, value) => sum + value, 0) / green.length;
  });
  demo.settings.type = "map";
  demo.changed("type");
  return tones;
};

/** Share of a picture of the car, seen from before and above, that is red as its paint, with so much snow on the car. */
export const PAINT = (snowed: number) => {
  const { car, stage, settings } = window.neveDrive!;
  const [x, y, z] = car.state.position;
  const camera = window.neveDrive!.camera.clone();
  camera.position.set(x + 3.4, y + 2.6, z + 2.4);
  camera.lookAt(x, y + 0.2, z);
  camera.updateMatrixWorld();
  stage.snowed = snowed;
  stage.update(0, car.state, camera, settings);
  stage.render(camera);
  const copy = Object.assign(document.createElement("canvas"), { width: 160, height: 100 });
  const pen = copy.getContext("2d", { willReadFrequently: true })!;
  pen.drawImage(document.querySelector("canvas")!, 0, 0, 160, 100);
  const { data } = pen.getImageData(0, 0, 160, 100);
  let red = 0;
  for (let k = 0; k < data.length; k += 4) if (data[k]! > 60 && data[k]! > 1.7 * data[k + 1]!) red++;
  return red / 16_000;
};

/**
 * Points of light on snow that lies before the camera: pixels of the lower half that are brighter than all about them
 * by 30 of 255, for each thousand of them, at an hour; the camera looks toward the sun.
 */
export const GLINTS = (hour: number) => {
  const demo = window.neveDrive!;
  const { stage, settings, car } = demo;
  const [width, height] = [360, 220];
  const view = document.querySelector("canvas")!;
  const before = [demo.camera.aspect, view.width, view.height] as const;
  demo.resize(width, height, 1);
  const [usual, camera] = [settings.hour, demo.camera.clone()];
  settings.hour = hour;
  stage.update(0, car.state, camera, settings);
  const sun = stage.toLight;
  const flat = Math.hypot(sun.x, sun.z);
  const [a, b] = [sun.x / flat, sun.z / flat];
  const [x, , z] = car.state.position;
  // Nine metres beside the car, where no wheel has been.
  const [ex, ez] = [x + 9 * b, z - 9 * a];
  const high = (px: number, pz: number) => demo.terrain.height(px, pz) + settings.depth;
  camera.position.set(ex, high(ex, ez) + 1.1, ez);
  camera.lookAt(ex + 6 * a, high(ex + 6 * a, ez + 6 * b), ez + 6 * b);
  camera.updateMatrixWorld();
  stage.update(0, car.state, camera, settings);
  stage.render(camera);
  const copy = Object.assign(document.createElement("canvas"), { width, height });
  const pen = copy.getContext("2d", { willReadFrequently: true })!;
  pen.drawImage(view, 0, 0);
  const { data } = pen.getImageData(0, 0, width, height);
  const green = (px: number, py: number) => data[4 * (px + width * py) + 1]!;
  let points = 0;
  for (let py = height / 2; py < height - 2; py++)
    for (let px = 2; px < width - 2; px++) {
      let about = 0;
      for (let k = 0; k < 25; k++) {
        const [dx, dy] = [(k % 5) - 2, Math.floor(k / 5) - 2];
        if (Math.max(Math.abs(dx), Math.abs(dy)) === 2) about = Math.max(about, green(px + dx, py + dy));
      }
      if (green(px, py) > about + 30) points++;
    }
  settings.hour = usual;
  demo.resize(before[1], before[2], 1);
  return (1000 * points) / ((width - 4) * (height / 2 - 2));
};

/**
 * Mean brightness (0..255) of a ball of snow a metre over the ground at an hour: a clod that flies and a lump as it lies,
 * each seen from where the sun stands and toward the sun.
 */
export const CLODS = (hour: number) => {
  const demo = window.neveDrive!;
  const { stage, settings, car } = demo;
  const size = 100;
  const view = document.querySelector("canvas")!;
  const before = [view.width, view.height] as const;
  demo.resize(size, size, 1);
  const usual = settings.hour;
  settings.hour = hour;
  const camera = demo.camera.clone();
  stage.update(0, car.state, camera, settings);
  const sun = stage.toLight;
  const flat = Math.hypot(sun.x, sun.z);
  const [a, b] = [sun.x / flat, sun.z / flat];
  // Nine metres beside the car, where it throws no shadow.
  const [x, z] = [car.state.position[0] + 9 * b, car.state.position[2] - 9 * a];
  const y = demo.terrain.height(x, z) + settings.depth + 1;
  const flying = stage["spray"]["motion"];
  const lying = stage["lying"];
  const copy = Object.assign(document.createElement("canvas"), { width: size, height: size });
  const pen = copy.getContext("2d", { willReadFrequently: true })!;
  const seen = (toward: number) => {
    camera.position.set(x - 2 * toward * a, y, z - 2 * toward * b);
    camera.lookAt(x, y, z);
    camera.updateMatrixWorld();
    stage.update(0, car.state, camera, settings);
    stage.render(camera);
    pen.drawImage(view, 0, 0);
    const { data } = pen.getImageData(0.44 * size, 0.44 * size, 0.12 * size, 0.12 * size);
    return data.reduce((sum, value, k) => sum + (k % 4 < 3 ? value : 0), 0) / (0.75 * data.length);
  };
  flying.grains.set([x, y, z, 0.8, 1, 0.5, 1, 0]);
  flying["lives"][0] = 1;
  flying["speeds"].fill(0);
  flying.count = 1;
  const clod = [seen(-1), seen(1)] as const;
  flying.count = 0;
  lying.lumps.set([x, y, z, 0.8, 0.5, 0]);
  lying.count = Math.max(1, lying.count);
  lying.changed = true;
  const lump = [seen(-1), seen(1)] as const;
  lying.lumps[3] = 0;
  lying.changed = true;
  settings.hour = usual;
  demo.resize(before[0], before[1], 1);
  return { clod, lump };
};

/** Share of the pixels that a picture and the same, drawn a pixel aside and moved back, do not have in common. */
export const ASIDE = () => {
  const { camera, stage } = window.neveDrive!;
  const view = document.querySelector("canvas")!;
  const { width, height } = view;
  const copy = Object.assign(document.createElement("canvas"), { width, height });
  const pen = copy.getContext("2d", { willReadFrequently: true })!;
  const [whole, moved] = [0, 1].map((aside) => {
    camera.setViewOffset(width, height, aside, 0, width, height);
    stage.render(camera);
    pen.drawImage(view, 0, 0);
    return pen.getImageData(0, 0, width, height).data;
  }) as [Uint8ClampedArray, Uint8ClampedArray];
  camera.clearViewOffset();
  let other = 0;
  for (let y = 0; y < height; y++)
    for (let x = 0; x < width - 1; x++) {
      const at = 4 * (x + width * y);
      if ([0, 1, 2].some((k) => Math.abs(whole[at + 4 + k]! - moved[at + k]!) > 12)) other++;
    }
  return other / ((width - 1) * height);
};
