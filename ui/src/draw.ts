/** Draws a map on a canvas. */

import type { Grid, Pose } from "./figures.ts";
import { placed } from "./figures.ts";

export interface Layer {
  name: string;
  colour: string;
  poses: Pose[];
  /** Whether the poses are a trail, which ends at the current pose. */
  trail: boolean;
  points: Pose[];
  /** The pose around which the points are drawn. */
  frame: string;
  grid: Grid | undefined;
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
const ARROW = 14;

function extent(layers: readonly Layer[]): [number, number, number, number] {
  let [left, right, low, high] = [Infinity, -Infinity, Infinity, -Infinity];
  const include = ({ x, y }: Pose) => {
    if (!Number.isFinite(x) || !Number.isFinite(y)) return;
    [left, right, low, high] = [Math.min(left, x), Math.max(right, x), Math.min(low, y), Math.max(high, y)];
  };
  for (const layer of layers) {
    layer.poses.forEach(include);
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

/** Draws layers; sizes are those of the canvas in CSS pixels. */
export function draw(canvas: HTMLCanvasElement, layers: readonly Layer[], view: View): void {
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  const ratio = window.devicePixelRatio;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio))
    [canvas.width, canvas.height] = [Math.round(width * ratio), Math.round(height * ratio)];
  const context = canvas.getContext("2d")!;
  const text = getComputedStyle(canvas).color;
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  const across = (x: number) => width / 2 + (x - view.x) * view.scale;
  const down = (y: number) => height / 2 - (y - view.y) * view.scale;
  for (const { grid } of layers) if (grid) drawGrid(context, grid, view, width, height);
  const step = round(110 / view.scale);
  drawLines(context, view, width, height, step);
  for (const layer of layers) {
    context.strokeStyle = context.fillStyle = layer.colour;
    for (const { x, y } of layer.points) context.fillRect(across(x) - 1.5, down(y) - 1.5, 3, 3);
    context.lineWidth = 2;
    context.setLineDash(layer.trail ? [] : [6, 4]);
    context.beginPath();
    for (const { x, y } of layer.poses) context.lineTo(across(x), down(y));
    context.stroke();
    context.setLineDash([]);
    const last = layer.poses.at(-1);
    if (last) drawArrow(context, across(last.x), down(last.y), last.heading, text);
  }
  drawScale(context, view, height, step, text);
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

function drawArrow(context: CanvasRenderingContext2D, x: number, y: number, heading: number, text: string): void {
  context.save();
  context.translate(x, y);
  context.beginPath();
  if (Number.isNaN(heading)) context.arc(0, 0, ARROW / 3, 0, 2 * Math.PI);
  else {
    context.rotate(-heading);
    context.moveTo(ARROW, 0);
    context.lineTo(-ARROW * 0.6, ARROW * 0.6);
    context.lineTo(-ARROW * 0.3, 0);
    context.lineTo(-ARROW * 0.6, -ARROW * 0.6);
    context.closePath();
  }
  context.fill();
  context.lineWidth = 1;
  context.strokeStyle = text;
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
