import * as three from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import type { Geom, Pose, SceneData } from "./ask";

export interface World {
  show: (data: SceneData, keepView: boolean) => void;
  move: (bodies: number[], poses: Pose[]) => void;
  // Where the tip would leave dots with the bodies standing so.
  dot: (bodies: number[], poses: Pose[]) => void;
  clearDots: () => void;
  countDots: (shown: number) => void;
  turn: (around: number, up: number) => void;
  zoom: (by: number) => void;
  home: () => void;
  free: () => void;
}

// MuJoCo's z is up, three's is y: all of the machine hangs in a group that is turned.
function place(object: three.Object3D, pose: Pose) {
  object.position.set(pose[0] ?? 0, pose[1] ?? 0, pose[2] ?? 0);
  object.quaternion.set(pose[4] ?? 0, pose[5] ?? 0, pose[6] ?? 0, pose[3] ?? 1).normalize();
}

function meshShape(mesh: SceneData["meshes"][number]): three.BufferGeometry {
  const indexed = new three.BufferGeometry();
  indexed.setAttribute("position", new three.Float32BufferAttribute(mesh.vertices_mm, 3));
  indexed.setIndex(mesh.faces);
  const shape = indexed.toNonIndexed();
  shape.computeVertexNormals();
  indexed.dispose();
  return shape;
}

function shapeOf(geom: Geom, data: SceneData): three.BufferGeometry | null {
  const [a = 1, b = 1, c = 1] = geom.size_mm;
  const along = (shape: three.BufferGeometry) => shape.rotateX(Math.PI / 2);
  if (geom.type === "box") return new three.BoxGeometry(2 * a, 2 * b, 2 * c);
  if (geom.type === "cylinder") return along(new three.CylinderGeometry(a, a, 2 * b, 28));
  if (geom.type === "capsule") return along(new three.CapsuleGeometry(a, 2 * b, 8, 20));
  if (geom.type === "sphere") return new three.SphereGeometry(a, 24, 16);
  if (geom.type === "ellipsoid") return new three.SphereGeometry(1, 24, 16).scale(a, b, c);
  const mesh = geom.type === "mesh" && geom.mesh !== null ? data.meshes[geom.mesh] : undefined;
  return mesh ? meshShape(mesh) : null;
}

function geomMesh(geom: Geom, data: SceneData): three.Object3D | null {
  const shape = shapeOf(geom, data);
  if (!shape) return null;
  const [red = 0.6, green = 0.6, blue = 0.6, alpha = 1] = geom.rgba;
  const colour = new three.Color().setRGB(red, green, blue, three.SRGBColorSpace);
  const mesh = new three.Mesh(shape, new three.MeshStandardMaterial({
    color: colour, roughness: 0.65, metalness: 0.1, transparent: alpha < 1, opacity: alpha,
  }));
  mesh.castShadow = alpha === 1;
  mesh.receiveShadow = true;
  place(mesh, geom.pose);
  return mesh;
}

function freeAll(root: three.Object3D) {
  root.traverse((one) => {
    if (!(one instanceof three.Mesh || one instanceof three.InstancedMesh)) return;
    one.geometry.dispose();
    for (const material of [one.material].flat()) (material as three.Material).dispose();
    if (one instanceof three.InstancedMesh) one.dispose();
  });
  root.clear();
}

const mostDots = 4000;

// Dots stay on the bed where it moves, else in the room.
class Dots {
  private mesh: three.InstancedMesh | null = null;
  private holder = 0;
  count = 0;
  constructor(private bodies: three.Group[], data: SceneData, size: number) {
    const bed = data.bodies.findIndex((name) => name === "bed");
    this.holder = Math.max(0, bed);
    const shape = new three.SphereGeometry(size * 0.006, 12, 8);
    this.mesh = new three.InstancedMesh(shape, new three.MeshBasicMaterial({ color: 0xe8590c }), mostDots);
    this.mesh.count = 0;
    this.mesh.frustumCulled = false;
    bodies[this.holder]?.add(this.mesh);
  }

  add(moving: number[], poses: Pose[]) {
    if (!this.mesh || this.count >= mostDots) return;
    const poseOf = (body: number) => poses[moving.indexOf(body)];
    const tip = poseOf(this.bodies.length - 1);
    if (!tip) return;
    const at = new three.Vector3(tip[0], tip[1], tip[2]);
    const bed = poseOf(this.holder);
    const frame = new three.Object3D();
    if (bed) place(frame, bed);
    else frame.applyMatrix4(this.bodies[this.holder]!.matrix);
    frame.updateMatrix();
    at.applyMatrix4(frame.matrix.invert());
    this.mesh.setMatrixAt(this.count++, new three.Matrix4().setPosition(at));
    this.mesh.instanceMatrix.needsUpdate = true;
  }

  show(count: number) {
    if (this.mesh) this.mesh.count = Math.min(count, this.count);
  }

  clear() {
    this.count = 0;
    this.show(0);
  }
}

// What the view is fitted to: all but the floor.
function extentOf(root: three.Object3D): three.Box3 {
  root.updateMatrixWorld(true);
  const box = new three.Box3().setFromObject(root);
  return box.isEmpty() ? new three.Box3(new three.Vector3(0, 0, -300), new three.Vector3(300, 300, 0)) : box;
}

class Eye {
  camera = new three.PerspectiveCamera(35, 1, 1, 20000);
  controls: OrbitControls;
  private extent = new three.Box3();
  constructor(canvas: HTMLCanvasElement) {
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enablePan = false;
    this.controls.enableZoom = false;
    canvas.style.touchAction = "pan-y";
  }

  fit(extent: three.Box3) {
    this.extent = extent;
    this.home();
  }

  home() {
    const sphere = this.extent.getBoundingSphere(new three.Sphere());
    const half = Math.min(this.camera.fov / 2, Math.atan(Math.tan((this.camera.fov * Math.PI) / 360) * this.camera.aspect) * (180 / Math.PI));
    const far = (sphere.radius / Math.sin((half * Math.PI) / 180)) * 0.92;
    this.controls.minDistance = sphere.radius * 0.15;
    this.controls.maxDistance = far * 2.5;
    this.controls.target.copy(sphere.center);
    this.camera.position.copy(sphere.center).add(new three.Vector3(-0.55, 0.42, 0.9).normalize().multiplyScalar(far));
    this.controls.update();
  }

  spin(around: number, up: number, zoom: number) {
    const { camera, controls } = this;
    const at = new three.Spherical().setFromVector3(camera.position.clone().sub(controls.target));
    at.theta += around;
    at.phi = Math.max(0.05, Math.min(Math.PI - 0.05, at.phi - up));
    at.radius = Math.max(controls.minDistance, Math.min(controls.maxDistance, at.radius * zoom));
    camera.position.setFromSpherical(at).add(controls.target);
    controls.update();
  }
}

function lightsFor(world: three.Scene): three.DirectionalLight {
  const sun = new three.DirectionalLight(0xffffff, 2.2);
  sun.castShadow = true;
  sun.shadow.mapSize.set(2048, 2048);
  sun.shadow.bias = -0.0005;
  sun.shadow.normalBias = 1.5;
  const fill = new three.DirectionalLight(0xffffff, 0.7);
  fill.position.set(-2, 1, -1);
  world.add(sun, sun.target, fill, new three.HemisphereLight(0xffffff, 0x8a94a0, 1.5));
  return sun;
}

function aim(sun: three.DirectionalLight, extent: three.Box3) {
  const sphere = extent.getBoundingSphere(new three.Sphere());
  sun.target.position.copy(sphere.center);
  sun.position.copy(sphere.center).add(new three.Vector3(-0.5, 1.6, 0.9).multiplyScalar(sphere.radius * 1.5));
  const { camera } = sun.shadow;
  camera.left = camera.bottom = -sphere.radius;
  camera.right = camera.top = sphere.radius;
  camera.near = 1;
  camera.far = sphere.radius * 5;
  camera.updateProjectionMatrix();
}

function listen(canvas: HTMLCanvasElement, eye: Eye, draw: () => void): () => void {
  const host = canvas.parentElement!;
  const sizes = new ResizeObserver(draw);
  // The wheel scrolls the page until somebody chose the view.
  const wheelOn = () => { eye.controls.enableZoom = true; };
  const wheelOff = () => { eye.controls.enableZoom = false; };
  eye.controls.addEventListener("change", draw);
  sizes.observe(canvas);
  host.addEventListener("focusin", wheelOn);
  host.addEventListener("focusout", wheelOff);
  return () => {
    sizes.disconnect();
    host.removeEventListener("focusin", wheelOn);
    host.removeEventListener("focusout", wheelOff);
    eye.controls.dispose();
  };
}

// A floor under the machine that only shows its shadow, whatever the background.
function floorAt(height: number, extent: three.Box3): three.Mesh {
  const size = extent.getSize(new three.Vector3()).length() * 4;
  const floor = new three.Mesh(new three.PlaneGeometry(size, size).rotateX(-Math.PI / 2), new three.ShadowMaterial({ opacity: 0.22 }));
  floor.position.set((extent.min.x + extent.max.x) / 2, height, (extent.min.z + extent.max.z) / 2);
  floor.receiveShadow = true;
  return floor;
}

function bodiesOf(data: SceneData): three.Group[] {
  const bodies = data.bodies.map((_, i) => {
    const body = new three.Group();
    if (data.poses[i]) place(body, data.poses[i]);
    return body;
  });
  for (const geom of data.geoms) {
    const mesh = geomMesh(geom, data);
    if (mesh) bodies[geom.body]?.add(mesh);
  }
  return bodies;
}

export function makeWorld(canvas: HTMLCanvasElement): World {
  const renderer = new three.WebGLRenderer({ canvas, antialias: true, alpha: true });
  renderer.shadowMap.enabled = true;
  renderer.shadowMap.type = three.PCFShadowMap;
  const world = new three.Scene();
  const machine = new three.Group();
  machine.rotation.x = -Math.PI / 2;
  const room = new three.Group();
  world.add(machine, room);
  const sun = lightsFor(world);
  const eye = new Eye(canvas);
  let bodies: three.Group[] = [];
  let dots: Dots | null = null;
  let frame = 0;
  const paint = () => {
    frame = 0;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (!width || !height) return;
    renderer.setPixelRatio(Math.min(2, devicePixelRatio));
    renderer.setSize(width, height, false);
    eye.camera.aspect = width / height;
    eye.camera.updateProjectionMatrix();
    renderer.render(world, eye.camera);
  };
  const draw = () => { frame ||= requestAnimationFrame(paint); };
  const deaf = listen(canvas, eye, draw);
  return {
    show: (data, keepView) => {
      freeAll(machine);
      freeAll(room);
      bodies = bodiesOf(data);
      machine.add(...bodies);
      const extent = extentOf(machine);
      const plane = data.geoms.find((geom) => geom.type === "plane");
      room.add(floorAt(plane?.pose[2] ?? extent.min.y, extent));
      dots = new Dots(bodies, data, extent.getSize(new three.Vector3()).length());
      aim(sun, extent);
      eye.camera.aspect = canvas.clientWidth / Math.max(1, canvas.clientHeight);
      if (!keepView) eye.fit(extent);
      draw();
    },
    move: (moving, poses) => {
      moving.forEach((body, i) => { if (bodies[body] && poses[i]) place(bodies[body], poses[i]); });
      draw();
    },
    dot: (moving, poses) => dots?.add(moving, poses),
    clearDots: () => { dots?.clear(); draw(); },
    countDots: (shown) => { dots?.show(shown); draw(); },
    turn: (around, up) => eye.spin(around, up, 1),
    zoom: (by) => eye.spin(0, 0, by),
    home: () => eye.home(),
    free: () => {
      cancelAnimationFrame(frame);
      deaf();
      freeAll(machine);
      freeAll(room);
      renderer.dispose();
    },
  };
}
