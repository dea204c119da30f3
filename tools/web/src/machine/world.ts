import * as three from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import type { Pose, SceneData } from "./data";
import { Errors, type Mark } from "./errors";
import { bodiesOf, Dots, freeAll, holderOf, place, Rods, tipOn } from "./shapes";

export interface World {
  show: (data: SceneData, keepView: boolean) => void;
  move: (bodies: number[], poses: Pose[]) => void;
  // Where the tip would leave dots with the bodies standing so.
  dot: (bodies: number[], poses: Pose[]) => void;
  clearDots: () => void;
  countDots: (shown: number) => void;
  // Where the tip is at each pose, for `mark`; null: out of reach.
  tips: (bodies: number[], poses: (Pose[] | null)[]) => ([number, number, number] | null)[];
  // Draws errors at places that reach over so much, instead of those before.
  mark: (marks: Mark[], size_mm: number) => void;
  exaggerate: (times: number) => void;
  turn: (around: number, up: number) => void;
  zoom: (by: number) => void;
  home: () => void;
  free: () => void;
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
  // Whether somebody chose the view: then it stays.
  private isChosen = false;
  constructor(canvas: HTMLCanvasElement) {
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enablePan = false;
    this.controls.enableZoom = false;
    this.controls.addEventListener("start", () => { this.isChosen = true; });
    canvas.style.touchAction = "pan-y";
  }

  fit(extent: three.Box3) {
    this.extent = extent;
    this.home();
  }

  shape(aspect: number) {
    if (Math.abs(aspect - this.camera.aspect) < 1e-3) return;
    this.camera.aspect = aspect;
    this.camera.updateProjectionMatrix();
    if (!this.isChosen && !this.extent.isEmpty()) this.home();
  }

  home() {
    this.isChosen = false;
    const sphere = this.extent.getBoundingSphere(new three.Sphere());
    const half = Math.min(this.camera.fov / 2, Math.atan(Math.tan((this.camera.fov * Math.PI) / 360) * this.camera.aspect) * (180 / Math.PI));
    const far = (sphere.radius / Math.sin((half * Math.PI) / 180)) * 0.98;
    this.controls.minDistance = sphere.radius * 0.15;
    this.controls.maxDistance = far * 2.5;
    this.controls.target.copy(sphere.center);
    this.camera.position.copy(sphere.center).add(new three.Vector3(-0.55, 0.42, 0.9).normalize().multiplyScalar(far));
    this.controls.update();
  }

  spin(around: number, up: number, zoom: number) {
    const { camera, controls } = this;
    this.isChosen = true;
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

// Paints at the next frame, once however often it is asked.
class Painter {
  private frame = 0;
  private renderer: three.WebGLRenderer;
  constructor(private canvas: HTMLCanvasElement, private world: three.Scene, private eye: Eye) {
    this.renderer = new three.WebGLRenderer({ canvas, antialias: true, alpha: true });
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = three.PCFShadowMap;
  }

  draw = () => { this.frame ||= requestAnimationFrame(this.paint); };

  private paint = () => {
    this.frame = 0;
    const [width, height] = [this.canvas.clientWidth, this.canvas.clientHeight];
    if (!width || !height) return;
    this.renderer.setPixelRatio(Math.min(2, devicePixelRatio));
    this.renderer.setSize(width, height, false);
    this.eye.shape(width / height);
    this.renderer.render(this.world, this.eye.camera);
  };

  free() {
    cancelAnimationFrame(this.frame);
    this.renderer.dispose();
  }
}

export function makeWorld(canvas: HTMLCanvasElement): World {
  const world = new three.Scene();
  const machine = new three.Group();
  machine.rotation.x = -Math.PI / 2;
  const room = new three.Group();
  world.add(machine, room);
  const sun = lightsFor(world);
  const eye = new Eye(canvas);
  const painter = new Painter(canvas, world, eye);
  const { draw } = painter;
  const deaf = listen(canvas, eye, draw);
  let bodies: three.Group[] = [];
  let rods: Rods | null = null;
  let dots: Dots | null = null;
  let errors: Errors | null = null;
  let holder = 0;
  return {
    show: (data, keepView) => {
      freeAll(machine);
      freeAll(room);
      bodies = bodiesOf(data);
      holder = holderOf(data);
      errors = null;
      rods = new Rods(bodies, data);
      machine.add(...bodies, ...rods.meshes());
      const extent = extentOf(machine);
      const plane = data.geoms.find((geom) => geom.type === "plane");
      room.add(floorAt(plane?.pose[2] ?? extent.min.y, extent));
      dots = new Dots(bodies, data, extent.getSize(new three.Vector3()).length());
      aim(sun, extent);
      if (!keepView) eye.fit(extent);
      draw();
    },
    move: (moving, poses) => {
      moving.forEach((body, i) => { if (bodies[body] && poses[i]) place(bodies[body], poses[i]); });
      rods?.follow();
      draw();
    },
    dot: (moving, poses) => dots?.add(moving, poses),
    tips: (moving, poses) => poses.map((pose) => (pose && tipOn(bodies, holder, moving, pose)?.toArray()) || null),
    mark: (marks, size_mm) => {
      if (errors) freeAll(errors);
      errors?.removeFromParent();
      // Thick enough to be seen from where all of the machine is.
      const whole_mm = extentOf(machine).getSize(new three.Vector3()).length();
      errors = new Errors(marks, Math.max(size_mm * 0.005, whole_mm * 0.0025));
      bodies[holder]?.add(errors);
      draw();
    },
    exaggerate: (times) => { errors?.exaggerate(times); draw(); },
    clearDots: () => { dots?.clear(); draw(); },
    countDots: (shown) => { dots?.show(shown); draw(); },
    turn: (around, up) => eye.spin(around, up, 1),
    zoom: (by) => eye.spin(0, 0, by),
    home: () => eye.home(),
    free: () => {
      deaf();
      freeAll(machine);
      freeAll(room);
      painter.free();
    },
  };
}
