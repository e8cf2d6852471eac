/** Draws a map on a canvas. */

import type { Grid, Pose } from "./figures.ts";
import type { Point } from "./layout.ts";
import { placed } from "./figures.ts";

export interface Layer {
  name: string;
  /** Short name, beside the mark of a pose. */
  label: string;
  colour: string;
  /** A body has a trail, a goal has none. */
  kind: "body" | "goal" | "path" | "scan" | "grid";
  pose: Pose | undefined;
  trail: readonly Pose[][];
  path: Pose[];
  points: Pose[];
  /** The pose around which the points are drawn. */
  frame: string;
  /** That pose, from which rays are drawn. */
  eye: Pose | undefined;
  grid: Grid | undefined;
}

/** What is measured on a map: from one point to another. */
export interface Measured {
  from: Pose;
  to: Pose;
}

/** The visible part of the world: centre [m] and scale [px/m]. */
export interface View {
  x: number;
  y: number;
  scale: number;
}

const MARGIN = 1.25;
/** Minimum size of the visible part [m]. */
const SMALLEST = 2;
/** Size of the mark of a body [px]. */
const BODY = 9;
/** The font of labels, the height of a line of it, and the distance from its mark and from the edge of the map [px]. */
const LABEL = { font: "11px system-ui, sans-serif", height: 12, gap: 5 };

function extent(layers: readonly Layer[]): [number, number, number, number] {
  let [left, right, low, high] = [Infinity, -Infinity, Infinity, -Infinity];
  const include = ({ x, y }: Pose) => {
    if (!Number.isFinite(x) || !Number.isFinite(y)) return;
    [left, right, low, high] = [Math.min(left, x), Math.max(right, x), Math.min(low, y), Math.max(high, y)];
  };
  for (const layer of layers) {
    if (layer.pose) include(layer.pose);
    layer.trail.flat().forEach(include);
    layer.path.forEach(include);
    layer.points.forEach(include);
    if (layer.grid) corners(layer.grid).forEach(include);
  }
  return left > right ? [-SMALLEST / 2, SMALLEST / 2, -SMALLEST / 2, SMALLEST / 2] : [left, right, low, high];
}

function corners({ columns, rows, width, height, origin }: Grid): Pose[] {
  const [w, h] = [columns * width, rows * height];
  return [[0, 0], [w, 0], [w, h], [0, h]].map(([x = 0, y = 0]) => placed({ x, y, heading: 0 }, origin));
}

/** The view that shows all layers. */
export function fitted(layers: readonly Layer[], width: number, height: number): View {
  const [left, right, low, high] = extent(layers);
  const size = (span: number) => Math.max(span * MARGIN, SMALLEST);
  return { x: (left + right) / 2, y: (low + high) / 2, scale: Math.min(width / size(right - left), height / size(high - low)) };
}

/** The greatest 1, 2 or 5 times a power of ten that is at most this. */
export function round(length: number): number {
  const power = 10 ** Math.floor(Math.log10(length));
  return power * ([5, 2, 1].find((each) => each * power <= length) ?? 1);
}

export const metres = (length: number): string =>
  length >= 1000 ? `${length / 1000} km` : length >= 1 ? `${length} m` : length >= 0.01 ? `${Math.round(length * 100)} cm` : `${Number((length * 1000).toPrecision(1))} mm`;

/** Grids as pictures, drawn once for each grid. */
const pictures = new WeakMap<Grid, HTMLCanvasElement>();

function picture(grid: Grid): HTMLCanvasElement {
  const known = pictures.get(grid);
  if (known) return known;
  const made = document.createElement("canvas");
  [made.width, made.height] = [grid.columns, grid.rows];
  const context = made.getContext("2d")!;
  const image = context.createImageData(grid.columns, grid.rows);
  for (let i = 0; i < grid.cells.length; i++) {
    const cell = grid.cells[i]!;
    const shade = Number.isNaN(cell) ? 140 : 255 * (1 - cell);
    image.data.set([shade, shade, shade, Number.isNaN(cell) ? 90 : 255], i * 4);
  }
  context.putImageData(image, 0, 0);
  pictures.set(grid, made);
  return made;
}

/** Draws layers, and what is measured; sizes are those of the canvas in CSS pixels. */
export function draw(canvas: HTMLCanvasElement, layers: readonly Layer[], view: View, measured: Measured | undefined, cross: boolean): void {
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  const ratio = window.devicePixelRatio;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio))
    [canvas.width, canvas.height] = [Math.round(width * ratio), Math.round(height * ratio)];
  const context = canvas.getContext("2d")!;
  const { color: text, backgroundColor: paper } = getComputedStyle(canvas);
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  const across = (x: number) => width / 2 + (x - view.x) * view.scale;
  const down = (y: number) => height / 2 - (y - view.y) * view.scale;
  const line = (poses: readonly Pose[], dash: number[]) => {
    context.setLineDash(dash);
    context.beginPath();
    for (const { x, y } of poses) context.lineTo(across(x), down(y));
    context.stroke();
    context.setLineDash([]);
  };
  for (const { grid } of layers) if (grid) drawGrid(context, grid, view, width, height);
  const step = round(110 / view.scale);
  drawLines(context, view, width, height, step);
  for (const { colour, points, eye } of layers) {
    context.fillStyle = context.strokeStyle = colour;
    if (eye) {
      context.globalAlpha = 0.12;
      context.beginPath();
      for (const { x, y } of points) {
        context.moveTo(across(eye.x), down(eye.y));
        context.lineTo(across(x), down(y));
      }
      context.lineWidth = 1;
      context.stroke();
      context.globalAlpha = 1;
    }
    for (const { x, y } of points) context.fillRect(across(x) - 1.5, down(y) - 1.5, 3, 3);
  }
  for (const { colour, trail, path } of layers) {
    context.strokeStyle = context.fillStyle = colour;
    context.lineWidth = 2;
    for (const part of trail) line(part, []);
    line(path, [6, 4]);
    for (const { x, y } of path.length <= MOST_MARKS ? path : []) context.fillRect(across(x) - 2, down(y) - 2, 4, 4);
  }
  const labels: Box[] = [];
  context.font = LABEL.font;
  for (const { kind, colour, pose, path, label } of layers) {
    const at = pose ?? path.at(-1);
    if (!at) continue;
    const [x, y] = [across(at.x), down(at.y)];
    context.fillStyle = context.strokeStyle = colour;
    if (kind === "body") drawBody(context, x, y, at.heading, text);
    else drawGoal(context, x, y, at.heading);
    const shown = shortened(context, label, Math.max(x, width - x) - BODY - 2 * LABEL.gap);
    const spot = labelPlace(x, y, context.measureText(shown).width, width, height, labels);
    if (!spot) continue;
    labels.push(spot);
    drawLabel(context, spot, shown, text, paper);
  }
  if (cross) line([{ x: view.x - 8 / view.scale, y: view.y, heading: 0 }, { x: view.x + 8 / view.scale, y: view.y, heading: 0 }], []);
  if (cross) line([{ x: view.x, y: view.y - 8 / view.scale, heading: 0 }, { x: view.x, y: view.y + 8 / view.scale, heading: 0 }], []);
  if (measured) {
    context.strokeStyle = context.fillStyle = text;
    context.lineWidth = 1.5;
    line([measured.from, measured.to], [3, 3]);
    for (const { x, y } of [measured.from, measured.to]) context.fillRect(across(x) - 2.5, down(y) - 2.5, 5, 5);
    const words = distance(measured);
    context.font = LABEL.font;
    const [x, y] = [across(measured.to.x), down(measured.to.y) + BODY];
    const wide = context.measureText(words).width;
    drawLabel(context, labelPlace(x, y, wide, width, height, []) ?? { x, y, wide }, words, text, paper);
  }
  drawScale(context, view, height, step, text);
}

/** Paths with more poses are drawn without a mark at each. */
const MOST_MARKS = 40;

export const distance = ({ from, to }: Measured): string => `${Math.hypot(to.x - from.x, to.y - from.y).toFixed(3)} m`;

/** A label that is at most `most` wide [px]: the middle of a longer one is left out. */
function shortened(context: CanvasRenderingContext2D, label: string, most: number): string {
  const { width } = context.measureText(label);
  if (width <= most) return label;
  const letters = [...label];
  for (let rest = Math.floor((letters.length * most) / width); rest > 1; rest--) {
    const text = `${letters.slice(0, Math.ceil(rest / 2)).join("")}…${letters.slice(-Math.floor(rest / 2)).join("")}`;
    if (context.measureText(text).width <= most) return text;
  }
  return "…";
}

/** The left end and the base line of a label, and its width [px]. */
interface Box extends Point {
  wide: number;
}

/** The lines beside a mark where its label may be, from its upper edge. */
const LINES = [0, 1, -1, 2, -2, 3, -3];

/** The place of a label beside its mark, where no other label is; undefined if there is none. */
function labelPlace(x: number, y: number, wide: number, width: number, height: number, labels: readonly Box[]): Box | undefined {
  const isInside = x >= 0 && x <= width && y >= 0 && y <= height;
  const [left, right] = [x - BODY - LABEL.gap - wide, x + BODY + LABEL.gap];
  const at = isInside && right + wide > width - LABEL.gap && left >= LABEL.gap ? left : right;
  const top = isInside ? Math.max(y - BODY, LABEL.height) : y - BODY;
  const line = LINES.map((each) => top + each * LABEL.height).find(
    (each) =>
      (!isInside || (each >= LABEL.height && each <= height - LABEL.gap)) &&
      !labels.some((other) => at < other.x + other.wide && other.x < at + wide && Math.abs(other.y - each) < LABEL.height),
  );
  return line === undefined ? undefined : { x: at, y: line, wide };
}

function drawLabel(context: CanvasRenderingContext2D, { x, y }: Point, label: string, text: string, paper: string): void {
  context.font = LABEL.font;
  context.lineWidth = 3;
  context.lineJoin = "round";
  context.strokeStyle = paper;
  context.strokeText(label, x, y);
  context.fillStyle = text;
  context.fillText(label, x, y);
}

function drawGrid(context: CanvasRenderingContext2D, grid: Grid, view: View, width: number, height: number): void {
  context.save();
  context.translate(width / 2, height / 2);
  context.scale(view.scale, -view.scale);
  context.translate(grid.origin.x - view.x, grid.origin.y - view.y);
  context.rotate(grid.origin.heading);
  context.scale(grid.width, grid.height);
  context.imageSmoothingEnabled = false;
  context.drawImage(picture(grid), 0, 0);
  context.restore();
}

function drawLines(context: CanvasRenderingContext2D, view: View, width: number, height: number, step: number): void {
  context.strokeStyle = "#8884";
  context.lineWidth = 1;
  context.beginPath();
  const [half, rise] = [width / 2 / view.scale, height / 2 / view.scale];
  for (let x = Math.ceil((view.x - half) / step) * step; x <= view.x + half; x += step) {
    const at = width / 2 + (x - view.x) * view.scale;
    context.moveTo(at, 0);
    context.lineTo(at, height);
  }
  for (let y = Math.ceil((view.y - rise) / step) * step; y <= view.y + rise; y += step) {
    const at = height / 2 - (y - view.y) * view.scale;
    context.moveTo(0, at);
    context.lineTo(width, at);
  }
  context.stroke();
}

/** A disc with a nose in the direction of its heading. */
function drawBody(context: CanvasRenderingContext2D, x: number, y: number, heading: number, text: string): void {
  context.save();
  context.translate(x, y);
  context.beginPath();
  if (Number.isNaN(heading)) context.arc(0, 0, BODY * 0.7, 0, 2 * Math.PI);
  else {
    context.rotate(-heading);
    context.arc(0, 0, BODY, Math.PI / 5, -Math.PI / 5);
    context.lineTo(BODY * 1.9, 0);
    context.closePath();
  }
  context.fill();
  context.lineWidth = 1;
  context.strokeStyle = text;
  context.stroke();
  context.restore();
}

/** A ring with a cross, and a line in the direction of its heading. */
function drawGoal(context: CanvasRenderingContext2D, x: number, y: number, heading: number): void {
  context.save();
  context.translate(x, y);
  context.lineWidth = 2;
  context.beginPath();
  context.arc(0, 0, BODY * 0.8, 0, 2 * Math.PI);
  for (const [dx, dy] of [[1, 0], [0, 1]] as const) {
    context.moveTo(-BODY * 0.4 * dx, -BODY * 0.4 * dy);
    context.lineTo(BODY * 0.4 * dx, BODY * 0.4 * dy);
  }
  if (!Number.isNaN(heading)) {
    context.moveTo(BODY * 0.8 * Math.cos(heading), -BODY * 0.8 * Math.sin(heading));
    context.lineTo(BODY * 2 * Math.cos(heading), -BODY * 2 * Math.sin(heading));
  }
  context.stroke();
  context.restore();
}

/** A scale bar, as long as the distance of the grid lines. */
function drawScale(context: CanvasRenderingContext2D, view: View, height: number, step: number, text: string): void {
  const length = step * view.scale;
  context.strokeStyle = context.fillStyle = text;
  context.lineWidth = 2;
  context.beginPath();
  context.moveTo(10, height - 16);
  context.lineTo(10, height - 10);
  context.lineTo(10 + length, height - 10);
  context.lineTo(10 + length, height - 16);
  context.stroke();
  context.font = "12px system-ui, sans-serif";
  context.fillText(metres(step), 16, height - 16);
}
