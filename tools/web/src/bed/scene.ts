import * as three from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { heightOf, offsetOf, residualColour, screwNames, type BedStatus, type Plane, type Screws, type Touch } from "./maths";

export type Shown = {
  status: BedStatus;
  plane: Plane | null;
  touches: Touch[];
  residuals: number[] | null;
  mostResidual: number;
  offsets: Screws | null;
  // Drawn flat: the height all screws come up to.
  level: number;
  exaggeration: number;
};

export type Label = { text: string; className: string; left: number; top: number };

export type Scene = {
  show: (shown: Shown) => void;
  turn: (around: number, up: number) => void;
  zoom: (by: number) => void;
  home: () => void;
  free: () => void;
};

const screwColours = ["--z1", "--z2", "--z3"];

// The colours of the page as it is now, light or dark.
function colourOf(host: HTMLElement, name: string): three.Color {
  const probe = document.createElement("span");
  probe.style.color = `var(${name})`;
  host.append(probe);
  const colour = new three.Color(getComputedStyle(probe).color);
  probe.remove();
  return colour;
}

function planeMesh(place: Place, colour: three.Color, shown: Shown): three.Object3D {
  const [width, depth] = place.travel;
  const plane = shown.plane!;
  const corner = (x: number, y: number) => place.at(x, y, heightOf(plane, x, y));
  const corners = [corner(0, 0), corner(width, 0), corner(width, depth), corner(0, depth)];
  const shape = new three.BufferGeometry().setFromPoints(corners);
  shape.setIndex([0, 1, 2, 0, 2, 3]);
  const group = new three.Group();
  group.add(new three.Mesh(shape, new three.MeshBasicMaterial({
    color: colour, transparent: true, opacity: 0.22, side: three.DoubleSide, depthWrite: false,
  })));
  const lines: three.Vector3[] = [];
  for (let i = 0; i <= 8; i++) {
    const x = (width * i) / 8;
    const y = (depth * i) / 8;
    lines.push(corner(x, 0), corner(x, depth), corner(0, y), corner(width, y));
  }
  group.add(new three.LineSegments(
    new three.BufferGeometry().setFromPoints(lines),
    new three.LineBasicMaterial({ color: colour, transparent: true, opacity: 0.6 }),
  ));
  return group;
}

type Place = {
  travel: [number, number];
  at: (x: number, y: number, z: number) => three.Vector3;
};

function placeOf(shown: Shown): Place {
  const travel: [number, number] = [shown.status.travel_mm[0]!, shown.status.travel_mm[1]!];
  return {
    travel,
    at: (x, y, z) => new three.Vector3(
      x - travel[0] / 2, (z - shown.level) * shown.exaggeration, travel[1] / 2 - y),
  };
}

function pillar(from: three.Vector3, to: three.Vector3, radius: number, colour: three.Color): three.Mesh {
  const height = Math.max(0.01, to.y - from.y);
  const mesh = new three.Mesh(
    new three.CylinderGeometry(radius, radius, height, 20),
    new three.MeshLambertMaterial({ color: colour }),
  );
  mesh.position.set(from.x, from.y + height / 2, from.z);
  return mesh;
}

function screwShapes(host: HTMLElement, place: Place, shown: Shown, labels: Anchor[]): three.Group {
  const group = new three.Group();
  const foot = Math.min(...shown.status.screws.map((screw) =>
    shown.plane ? place.at(0, 0, heightOf(shown.plane, screw.at_mm[0]!, screw.at_mm[1]!)).y : 0));
  shown.status.screws.forEach((screw, i) => {
    const [x, y] = [screw.at_mm[0]!, screw.at_mm[1]!];
    const colour = colourOf(host, screwColours[i] ?? "--ink");
    const top = place.at(x, y, shown.plane ? heightOf(shown.plane, x, y) : shown.level);
    const bottom = top.clone().setY(foot - place.travel[0] * 0.14);
    group.add(pillar(bottom, top, place.travel[0] * 0.013, colour));
    const name = screwNames[i]!;
    const offset = shown.offsets ? offsetOf(shown.offsets, name) : 0;
    const lift = offset * shown.exaggeration;
    if (lift > place.travel[0] * 0.03) {
      group.add(new three.ArrowHelper(
        new three.Vector3(0, 1, 0), top, lift, colour.getHex(), Math.min(14, lift * 0.4), 8));
    }
    labels.push({
      at: top.clone().setY(Math.max(top.y, 0) + place.travel[0] * 0.04),
      text: shown.offsets ? `${name} ${offset >= 0.0005 ? `+${offset.toFixed(3)} mm` : "stays"}` : name,
      className: `bed-label ${name}`,
    });
  });
  return group;
}

function touchShapes(place: Place, shown: Shown): three.Group {
  const group = new three.Group();
  const ball = new three.SphereGeometry(place.travel[0] * 0.017, 20, 14);
  shown.touches.forEach((touch, i) => {
    const colour = residualColour(shown.residuals?.[i] ?? null, shown.mostResidual);
    const mesh = new three.Mesh(ball, new three.MeshLambertMaterial({ color: new three.Color(colour) }));
    mesh.position.copy(place.at(touch.x, touch.y, touch.z));
    group.add(mesh);
  });
  return group;
}

function frame(place: Place, colour: three.Color, level: number): three.LineLoop {
  const [width, depth] = place.travel;
  const corners = [[0, 0], [width, 0], [width, depth], [0, depth]]
    .map(([x = 0, y = 0]) => place.at(x, y, level));
  const line = new three.LineLoop(
    new three.BufferGeometry().setFromPoints(corners),
    new three.LineDashedMaterial({ color: colour, dashSize: 6, gapSize: 4 }),
  );
  line.computeLineDistances();
  return line;
}

type Anchor = { at: three.Vector3; text: string; className: string };

function freeAll(root: three.Object3D) {
  root.traverse((one) => {
    if (!(one instanceof three.Mesh || one instanceof three.Line)) return;
    one.geometry.dispose();
    for (const material of [one.material].flat()) (material as three.Material).dispose();
  });
  root.clear();
}

function fill(host: HTMLElement, root: three.Group, shown: Shown): Anchor[] {
  const anchors: Anchor[] = [];
  const place = placeOf(shown);
  const [width, depth] = place.travel;
  root.add(frame(place, colourOf(host, "--soft"), shown.level));
  if (shown.plane) root.add(planeMesh(place, colourOf(host, "--accent"), shown));
  root.add(touchShapes(place, shown));
  root.add(screwShapes(host, place, shown, anchors));
  const soft = colourOf(host, "--soft").getHex();
  const from = place.at(-width * 0.06, -depth * 0.06, shown.level);
  const long = width * 0.2;
  root.add(
    new three.ArrowHelper(new three.Vector3(1, 0, 0), from, long, soft, 10, 6),
    new three.ArrowHelper(new three.Vector3(0, 0, -1), from, long, soft, 10, 6),
  );
  anchors.push(
    { at: from.clone().add(new three.Vector3(long * 1.15, 0, 0)), text: "x", className: "bed-label axis" },
    { at: from.clone().add(new three.Vector3(0, 0, -long * 1.15)), text: "y", className: "bed-label axis" },
  );
  return anchors;
}

function labelsOf(anchors: Anchor[], camera: three.Camera, canvas: HTMLCanvasElement): Label[] {
  return anchors.map(({ at, text, className }) => {
    const seen = at.clone().project(camera);
    return {
      text, className,
      left: ((seen.x + 1) / 2) * canvas.clientWidth,
      top: ((1 - seen.y) / 2) * canvas.clientHeight,
    };
  });
}

type Eye = { camera: three.PerspectiveCamera; controls: OrbitControls };

function eyeOn(canvas: HTMLCanvasElement): Eye {
  const camera = new three.PerspectiveCamera(38, 1, 1, 5000);
  const controls = new OrbitControls(camera, canvas);
  controls.enablePan = false;
  // The wheel scrolls the page until somebody chose the view.
  controls.enableZoom = false;
  controls.minDistance = 150;
  controls.maxDistance = 1500;
  canvas.style.touchAction = "pan-y";
  return { camera, controls };
}

function goHome({ camera, controls }: Eye, size: number, aspect: number) {
  const far = Math.max(1.02, 1.3 / aspect);
  controls.target.set(0, size * -0.14, size * 0.04);
  camera.position.set(size * -0.5 * far, size * 0.95 * far, size * 1.55 * far);
  controls.update();
}

function spin({ camera, controls }: Eye, around: number, up: number, zoom: number) {
  const place = new three.Spherical().setFromVector3(camera.position.clone().sub(controls.target));
  place.theta += around;
  place.phi = Math.max(0.05, Math.min(Math.PI - 0.05, place.phi - up));
  place.radius = Math.max(controls.minDistance, Math.min(controls.maxDistance, place.radius * zoom));
  camera.position.setFromSpherical(place).add(controls.target);
  controls.update();
}

function listen(canvas: HTMLCanvasElement, { controls }: Eye, draw: () => void, again: () => void) {
  const host = canvas.parentElement!;
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const sizes = new ResizeObserver(draw);
  const wheelOn = () => { controls.enableZoom = true; };
  const wheelOff = () => { controls.enableZoom = false; };
  controls.addEventListener("change", draw);
  dark.addEventListener("change", again);
  sizes.observe(canvas);
  host.addEventListener("focusin", wheelOn);
  host.addEventListener("focusout", wheelOff);
  return () => {
    sizes.disconnect();
    dark.removeEventListener("change", again);
    host.removeEventListener("focusin", wheelOn);
    host.removeEventListener("focusout", wheelOff);
    controls.dispose();
  };
}

function lights(): three.Object3D[] {
  const sun = new three.DirectionalLight(0xffffff, 1.6);
  sun.position.set(1, 2, 1.5);
  return [sun, new three.AmbientLight(0xffffff, 1.8)];
}

export function makeScene(canvas: HTMLCanvasElement, onLabels: (labels: Label[]) => void): Scene {
  const renderer = new three.WebGLRenderer({ canvas, antialias: true, alpha: true });
  const world = new three.Scene();
  const root = new three.Group();
  world.add(root, ...lights());
  const eye = eyeOn(canvas);
  let shown: Shown | null = null;
  let anchors: Anchor[] = [];
  const draw = () => {
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (!width || !height) return;
    renderer.setPixelRatio(Math.min(2, devicePixelRatio));
    renderer.setSize(width, height, false);
    eye.camera.aspect = width / height;
    eye.camera.updateProjectionMatrix();
    renderer.render(world, eye.camera);
    onLabels(labelsOf(anchors, eye.camera, canvas));
  };
  const show = (next: Shown) => {
    shown = next;
    freeAll(root);
    anchors = fill(canvas.parentElement!, root, next);
    draw();
  };
  const deaf = listen(canvas, eye, draw, () => shown && show(shown));
  return {
    show,
    home: () => goHome(eye, shown?.status.travel_mm[0] ?? 235, canvas.clientWidth / Math.max(1, canvas.clientHeight)),
    turn: (around, up) => spin(eye, around, up, 1),
    zoom: (by) => spin(eye, 0, 0, by),
    free: () => {
      deaf();
      freeAll(root);
      renderer.dispose();
    },
  };
}
