import * as three from "three";

// An error at a place, both in the frame of what it is drawn on.
export interface Mark { at_mm: [number, number, number]; n: [number, number, number]; um: number; sense: number }

const along = 0xe8590c;
const against = 0x1c7ed6;
const up = new three.Vector3(0, 1, 0);

function overAll(material: three.Material) {
  material.depthTest = false;
  material.transparent = true;
  return material;
}

function pins(shape: three.BufferGeometry, count: number): three.InstancedMesh {
  const mesh = new three.InstancedMesh(shape, overAll(new three.MeshBasicMaterial()), count);
  mesh.frustumCulled = false;
  mesh.renderOrder = 3;
  return mesh;
}

// Pairs of marks that are neighbours along X, Y or Z and show errors of one kind.
function neighbours(marks: Mark[]): [number, number][] {
  const found: [number, number][] = [];
  for (const axis of [0, 1, 2]) {
    const rows = new Map<string, number[]>();
    marks.forEach((mark, i) => {
      const beside = mark.at_mm.filter((_, k) => k !== axis).map((mm) => mm.toFixed(1));
      const key = [...beside, ...mark.n.map((part) => part.toFixed(2)), mark.sense].join(" ");
      rows.set(key, [...(rows.get(key) ?? []), i]);
    });
    for (const row of rows.values()) {
      row.sort((a, b) => marks[a]!.at_mm[axis]! - marks[b]!.at_mm[axis]!);
      row.slice(1).forEach((one, i) => found.push([row[i]!, one]));
    }
  }
  return found;
}

// Arrows at the measured places, and lines through where they point: what was a straight
// line or an even grid shows bent.
export class Errors extends three.Group {
  private stems: three.InstancedMesh;
  private heads: three.InstancedMesh;
  private bent: three.LineSegments;
  private pairs: [number, number][];
  private thick: number;
  constructor(private marks: Mark[], thick_mm: number) {
    super();
    this.thick = thick_mm;
    this.stems = pins(new three.CylinderGeometry(this.thick * 0.45, this.thick * 0.45, 1, 8).translate(0, 0.5, 0), marks.length);
    this.heads = pins(new three.ConeGeometry(this.thick * 1.5, this.thick * 4, 12).translate(0, this.thick * -2, 0), marks.length);
    this.pairs = neighbours(marks);
    const straight = this.lines(0x868e96, 1);
    this.bent = this.lines(0x2b8a3e, 2);
    this.join(straight, marks.map((mark) => new three.Vector3(...mark.at_mm)));
    this.add(straight, this.bent, this.stems, this.heads);
    marks.forEach((mark, i) => {
      const colour = new three.Color(mark.um < 0 ? against : along);
      this.stems.setColorAt(i, colour);
      this.heads.setColorAt(i, colour);
    });
  }

  private lines(color: number, order: number): three.LineSegments {
    const shape = new three.BufferGeometry();
    shape.setAttribute("position", new three.BufferAttribute(new Float32Array(this.pairs.length * 6), 3));
    const lines = new three.LineSegments(shape, overAll(new three.LineBasicMaterial({ color })));
    lines.frustumCulled = false;
    lines.renderOrder = order;
    return lines;
  }

  private join(lines: three.LineSegments, at: three.Vector3[]) {
    const position = lines.geometry.getAttribute("position") as three.BufferAttribute;
    this.pairs.forEach(([from, to], i) => {
      position.setXYZ(2 * i, at[from]!.x, at[from]!.y, at[from]!.z);
      position.setXYZ(2 * i + 1, at[to]!.x, at[to]!.y, at[to]!.z);
    });
    position.needsUpdate = true;
  }

  // Draws errors `times` as large as they are.
  exaggerate(times: number) {
    const ends = this.marks.map((mark, i) => {
      const from = new three.Vector3(...mark.at_mm);
      const move = new three.Vector3(...mark.n).multiplyScalar((mark.um / 1000) * times);
      const long = move.length();
      const turn = new three.Quaternion().setFromUnitVectors(up, long > 0 ? move.clone().divideScalar(long) : up);
      // A short arrow is nearly all head: the head shrinks with it.
      const head = Math.min(1, long / (this.thick * 5));
      const to = from.clone().add(move);
      this.stems.setMatrixAt(i, new three.Matrix4().compose(from, turn, new three.Vector3(1, Math.max(0, long - this.thick * 3 * head), 1)));
      this.heads.setMatrixAt(i, new three.Matrix4().compose(to, turn, new three.Vector3(head, head, head)));
      return to;
    });
    this.stems.instanceMatrix.needsUpdate = true;
    this.heads.instanceMatrix.needsUpdate = true;
    this.join(this.bent, ends);
  }
}
