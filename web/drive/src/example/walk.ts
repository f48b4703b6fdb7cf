// A page of one's own: a character walks over snow. Arrow keys turn it; docs/game_snow.md goes through it.
import * as THREE from "three";
import { costOf, footStamps, LEVEL, LEVEL_GROUND, SnowField } from "../snow";

const renderer = new THREE.WebGLRenderer({ antialias: true });
document.body.append(renderer.domElement);
const scene = new THREE.Scene();
scene.background = new THREE.Color(0xa9c4e4);
const camera = new THREE.PerspectiveCamera(45, 1, 0.1, 200);
const sun = new THREE.DirectionalLight(0xffe9cf, 5.5);
sun.position.set(-6, 2.2, 3);
scene.add(sun, new THREE.HemisphereLight(0xa9c8ff, 0x9fb4d0, 1.7));

// The snow: a window of 20 m with texels of 4 cm that follows the character.
const settings = { depth: 0.25, compaction: 0.7, rimShare: 0.8, repose: 45, recovery: Infinity, snowfall: 0 };
const field = new SnowField(renderer, {
  resolution: 512,
  texel: 0.04,
  ground: LEVEL_GROUND,
  terrain: LEVEL,
  settings,
});

// A plane of three.js, lifted by the depth and lit by its slope: `snowAt` comes with the field.
const material = new THREE.MeshStandardMaterial({ color: 0xf3f6fb, roughness: 0.85 });
material.onBeforeCompile = (shader) => {
  Object.assign(shader.uniforms, field.uniforms);
  const lift = `vec2 xz = (modelMatrix * vec4(position, 1.0)).xz;
    float e = 0.04, h = snowAt(xz).x;
    vec3 objectNormal = normalize(vec3(h - snowAt(xz + vec2(e, 0.0)).x, e, h - snowAt(xz + vec2(0.0, e)).x));`;
  shader.vertexShader = shader.vertexShader
    .replace("void main() {", `${field.glsl}\nvoid main() {`)
    .replace("#include <beginnormal_vertex>", lift)
    .replace("#include <begin_vertex>", "vec3 transformed = position + vec3(0.0, h, 0.0);");
};
const ground = new THREE.Mesh(new THREE.PlaneGeometry(16, 16, 400, 400).rotateX(-Math.PI / 2), material);
ground.frustumCulled = false;
const body = new THREE.Mesh(
  new THREE.CapsuleGeometry(0.22, 0.9),
  new THREE.MeshStandardMaterial({ color: 0xb2402e }),
);
scene.add(ground, body);

// The character: a step of 0.75 m every half second, left and right in turn; a foot sinks to 4 cm above the ground.
const walker = { x: 0, z: 0, heading: 0, way: 0, steps: 0, turn: 0 };
function walk(dt: number): void {
  walker.heading += 1.6 * walker.turn * dt;
  const [c, s] = [Math.cos(walker.heading), Math.sin(walker.heading)];
  walker.x += 1.5 * c * dt;
  walker.z += 1.5 * s * dt;
  walker.way += 1.5 * dt;
  const side = walker.steps % 2 ? 0.11 : -0.11;
  const foot = { x: walker.x - side * s, y: 0.04, z: walker.z + side * c, heading: walker.heading };
  const lands = walker.way > 0.75 * walker.steps;
  if (lands) walker.steps += 1;
  field.follow(walker.x, walker.z);
  field.update(dt, lands ? footStamps(foot) : []);
  body.position.set(walker.x, 0.85 + 0.03 * Math.sin(8.4 * walker.way), walker.z);
  ground.position.set(Math.round(walker.x), 0, Math.round(walker.z)); // whole metres: its corners stay on the texels
  camera.position.set(walker.x - 5 * c - 2 * s, 2.4, walker.z - 5 * s + 2 * c);
  camera.lookAt(walker.x - 1.2 * c, 0.3, walker.z - 1.2 * s);
}
const turns: Record<string, number> = { ArrowLeft: -1, ArrowRight: 1 };
addEventListener("keydown", (event) => (walker.turn = turns[event.key] ?? walker.turn));
addEventListener("keyup", () => (walker.turn = 0));
export function draw(): void {
  renderer.setSize(innerWidth, innerHeight);
  camera.aspect = innerWidth / innerHeight;
  camera.updateProjectionMatrix();
  renderer.render(scene, camera);
}
const page = { field, walker, walk, draw, cost: () => costOf(field) }; // for the console and the tests
Object.assign(window, { walkOnSnow: page });
export type WalkPage = typeof page;
if (!location.search.includes("held")) renderer.setAnimationLoop(() => (walk(1 / 60), draw()));
