/** Figures of samples on a map, determined by the members of their types. */

import type { TypeNode } from "./protocol/Ui.ts";
import type { TypeTable } from "./protocol/table.ts";

export interface Pose {
  x: number;
  y: number;
  /** Angle from the x axis [rad]; NaN for a point without a heading. */
  heading: number;
}

export interface Grid {
  columns: number;
  rows: number;
  /** Size of a cell [m]. */
  width: number;
  height: number;
  origin: Pose;
  /** Row by row, 0 free to 1 occupied; NaN for unknown. */
  cells: ArrayLike<number>;
}

/** The figure of a sample; the points of a scan are in the frame of the body. */
export type Figure =
  | { kind: "pose"; pose: Pose }
  | { kind: "path"; poses: Pose[] }
  | { kind: "scan"; points: Pose[] }
  | { kind: "grid"; grid: Grid };

// Samples match their types, so members found in the table can be read without checks.
type Value = Record<string, any>;

/** Maximum numbers of drawn points and cells. */
const MAX_POINTS = 20_000;
const MAX_CELLS = 1 << 22;

function yaw({ x, y, z, w }: Value): number {
  return Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z));
}

const point = (value: Value): Pose => ({ x: value["x"], y: value["y"], heading: NaN });

/** Poses by the members that their types must have: RTC, IIS, geometry_msgs. */
const POSES: readonly (readonly [members: string[], read: (value: Value) => Pose])[] = [
  [["position", "heading"], ({ position, heading }) => ({ x: position.x, y: position.y, heading })],
  [
    ["position", "orientation"],
    ({ position, orientation: turned }) => ({ x: position.x, y: position.y, heading: "w" in turned ? yaw(turned) : turned.y }),
  ],
  [["x", "y", "theta"], ({ x, y, theta }) => ({ x, y, heading: theta })],
];

/** A figure by the members that its type must have. */
type Form = readonly [members: string[], kind: Figure["kind"], read: (value: Value) => Figure | undefined];

const FIGURES: readonly Form[] = [
  // RTC::RangeData
  [["ranges", "geometry", "config"], "scan", rangeData],
  // sensor_msgs::msg::LaserScan
  [
    ["ranges", "angle_min", "angle_increment", "range_min", "range_max"],
    "scan",
    ({ ranges, angle_min, angle_increment, range_min, range_max }) =>
      scan(ranges, angle_min, angle_increment, range_min, range_max, { x: 0, y: 0, heading: 0 }),
  ],
  // nav_msgs::msg::OccupancyGrid
  [["info", "data"], "grid", occupancyGrid],
  ...POSES.map(([members, read]): Form => [members, "pose", (value) => ({ kind: "pose", pose: read(value) })]),
];

function scan(ranges: ArrayLike<number>, first: number, step: number, least: number, most: number, mount: Pose): Figure {
  const points: Pose[] = [];
  for (let i = 0; i < Math.min(ranges.length, MAX_POINTS); i++) {
    const range = ranges[i]!;
    if (!(range > 0 && range >= least && (most <= 0 || range <= most))) continue;
    const angle = first + i * step;
    points.push(placed({ x: range * Math.cos(angle), y: range * Math.sin(angle), heading: NaN }, mount));
  }
  return { kind: "scan", points };
}

function rangeData({ ranges, geometry, config }: Value): Figure {
  const { position, orientation } = geometry.geometry.pose;
  const mount = { x: position.x, y: position.y, heading: orientation.y };
  return scan(ranges, config.minAngle, config.angularRes, config.minRange, config.maxRange, mount);
}

function occupancyGrid({ info, data }: Value): Figure | undefined {
  const { width: columns, height: rows, resolution, origin } = info;
  if (!(columns > 0 && rows > 0 && resolution > 0 && columns * rows === data.length && data.length <= MAX_CELLS)) return undefined;
  const cells = Float32Array.from(data as ArrayLike<number>, (cell) => (cell < 0 || cell > 100 ? NaN : cell / 100));
  const pose = POSES[1]![1](origin);
  return { kind: "grid", grid: { columns, rows, width: resolution, height: resolution, origin: pose, cells } };
}

/** A point or pose that is given in the frame of another one. */
export function placed(point: Pose, frame: Pose): Pose {
  const turn = Number.isNaN(frame.heading) ? 0 : frame.heading;
  const [c, s] = [Math.cos(turn), Math.sin(turn)];
  return { x: frame.x + c * point.x - s * point.y, y: frame.y + s * point.x + c * point.y, heading: point.heading + turn };
}

/** Members that contain the figure: in RTC's timed types, messages with a header, poses with covariance. */
const INSIDE = ["data", "pose", "poses", "points"];
const DEEPEST = 4;

export interface Reader {
  kind: Figure["kind"];
  read: (value: unknown) => Figure | undefined;
}

/** Returns the reader of figures for a type; undefined if it cannot be drawn. */
export function reader(table: TypeTable, type: number, depth = 0): Reader | undefined {
  const node = table.nodes[type];
  if (!node || depth > DEEPEST) return undefined;
  if (node.kind === "TYPE_SEQUENCE") return listReader(table, node);
  if (node.kind !== "TYPE_STRUCT") return undefined;
  const names = new Set(node.members.map((each) => each.name));
  for (const [members, kind, read] of FIGURES)
    if (members.every((each) => names.has(each))) return { kind, read: (value) => read(value as Value) };
  for (const name of INSIDE) {
    const member = node.members.find((each) => each.name === name && !each.optional);
    const inner = member && reader(table, member.type, depth + 1);
    if (inner) return { kind: inner.kind, read: (value) => inner.read((value as Value)[name]) };
  }
  return undefined;
}

/** A sequence of poses is a path, one of points is a scan: obstacles in the frame of the body. */
function listReader(table: TypeTable, list: TypeNode): Reader | undefined {
  const inner = reader(table, list.element, DEEPEST - 1);
  const bounded = (value: unknown) => Array.from(value as ArrayLike<unknown>).slice(0, MAX_POINTS);
  if (inner?.kind === "pose")
    return {
      kind: "path",
      read: (value) => ({ kind: "path", poses: bounded(value).flatMap((each) => {
        const figure = inner.read(each);
        return figure?.kind === "pose" ? [figure.pose] : [];
      }) }),
    };
  const read = pointReader(table, list.element);
  return read && { kind: "scan", read: (value) => ({ kind: "scan", points: bounded(value).map((each) => read(each as Value)) }) };
}

function pointReader(table: TypeTable, type: number): ((value: Value) => Pose) | undefined {
  const node = table.nodes[type];
  if (node?.kind !== "TYPE_STRUCT") return undefined;
  const names = new Set(node.members.map((each) => each.name));
  if (names.has("x") && names.has("y")) return point;
  const inner = node.members.find((each) => each.name === "point");
  return inner && pointReader(table, inner.type) && ((value) => point(value["point"] as Value));
}
