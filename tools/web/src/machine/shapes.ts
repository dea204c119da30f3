import * as three from "three";
import type { Geom, Pose, SceneData } from "./data";

// MuJoCo's z is up, three's is y: all of the machine hangs in a group that is turned.
export function place(object: three.Object3D, pose: Pose) {
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

function painted(shape: three.BufferGeometry, rgba: number[]): three.Mesh {
  const [red = 0.6, green = 0.6, blue = 0.6, alpha = 1] = rgba;
  const mesh = new three.Mesh(shape, new three.MeshStandardMaterial({
    color: new three.Color().setRGB(red, green, blue, three.SRGBColorSpace),
    roughness: 0.65, metalness: 0.1, transparent: alpha < 1, opacity: alpha,
  }));
  mesh.castShadow = alpha === 1;
  mesh.receiveShadow = true;
  return mesh;
}

function geomMesh(geom: Geom, data: SceneData): three.Object3D | null {
  const shape = shapeOf(geom, data);
  if (!shape) return null;
  const mesh = painted(shape, geom.rgba);
  place(mesh, geom.pose);
  return mesh;
}

// Rods from one body to another: they follow when bodies move.
export class Rods {
  private rods: { mesh: three.Mesh; ends: [three.Group, three.Vector3][] }[];
  constructor(bodies: three.Group[], data: SceneData) {
    this.rods = data.rods.map(({ bodies: on, ends_mm, radius_mm, rgba }) => ({
      mesh: painted(new three.CylinderGeometry(radius_mm, radius_mm, 1, 16), rgba),
      ends: on.map((body, i) => [bodies[body]!, new three.Vector3(...ends_mm[i]!)]),
    }));
    this.follow();
  }

  meshes = () => this.rods.map(({ mesh }) => mesh);

  follow() {
    for (const { mesh, ends } of this.rods) {
      const [from, to] = ends.map(([body, at]) => {
        body.updateMatrix();
        return at.clone().applyMatrix4(body.matrix);
      }) as [three.Vector3, three.Vector3];
      const along = to.clone().sub(from);
      mesh.position.copy(from).addScaledVector(along, 0.5);
      mesh.scale.y = Math.max(1e-6, along.length());
      mesh.quaternion.setFromUnitVectors(new three.Vector3(0, 1, 0), along.normalize());
    }
  }
}

export function freeAll(root: three.Object3D) {
  root.traverse((one) => {
    if (!(one instanceof three.Mesh || one instanceof three.LineSegments)) return;
    one.geometry.dispose();
    for (const material of [one.material].flat()) (material as three.Material).dispose();
    if (one instanceof three.InstancedMesh) one.dispose();
  });
  root.clear();
}

// Things on the bed move with it, where it moves; else they stay in the room.
export const holderOf = (data: SceneData) => Math.max(0, data.bodies.findIndex((name) => name === "bed"));

// Where the tip is, as the holder has it; null: out of reach.
export function tipOn(bodies: three.Group[], holder: number, moving: number[], poses: Pose[]): three.Vector3 | null {
  const poseOf = (body: number) => poses[moving.indexOf(body)];
  const tip = poseOf(bodies.length - 1);
  if (!tip) return null;
  const frame = new three.Object3D();
  const bed = poseOf(holder);
  if (bed) place(frame, bed);
  else frame.applyMatrix4(bodies[holder]!.matrix);
  frame.updateMatrix();
  return new three.Vector3(tip[0], tip[1], tip[2]).applyMatrix4(frame.matrix.invert());
}

const mostDots = 4000;

export class Dots {
  private mesh: three.InstancedMesh | null = null;
  private holder = 0;
  count = 0;
  constructor(private bodies: three.Group[], data: SceneData, size: number) {
    this.holder = holderOf(data);
    const shape = new three.SphereGeometry(size * 0.006, 12, 8);
    this.mesh = new three.InstancedMesh(shape, new three.MeshBasicMaterial({ color: 0xe8590c, depthTest: false, transparent: true }), mostDots);
    this.mesh.count = 0;
    this.mesh.frustumCulled = false;
    this.mesh.renderOrder = 1;
    bodies[this.holder]?.add(this.mesh);
  }

  add(moving: number[], poses: Pose[]) {
    if (!this.mesh || this.count >= mostDots) return;
    const at = tipOn(this.bodies, this.holder, moving, poses);
    // Out of reach: counted, not seen.
    if (!at) {
      this.mesh.setMatrixAt(this.count++, new three.Matrix4().makeScale(0, 0, 0));
      return;
    }
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

export function bodiesOf(data: SceneData): three.Group[] {
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
