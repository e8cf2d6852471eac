/** Routes of wires around boxes: right angles only, few bends, no two wires of unlike sources on one line (A* on the lines beside the boxes). */

import type { Point } from "./layout.ts";

export interface Rectangle extends Point {
  width: number;
  height: number;
}

/** A wire from a port, which it leaves to the right, to one that it reaches from the left. */
export interface Ends {
  name: string;
  from: Point;
  to: Point;
}

/** The distances of lines from a box [px]. */
const LANES = [12, 20, 28];
/** The least distance from a box [px]. */
export const CLEAR = 6;
const BEND = 40;
/** What a pixel on the line of another wire costs. */
const SHARED = 4;
/** How far around its ends a wire looks for its way first, then everywhere [px]. */
const REACH = 300;
/** A wire that has visited as many places takes none. */
const PATIENCE = 60_000;

/** The lines that are taken, by their place: parts of them with the port that the wire comes from. */
export class Taken {
  private readonly lines = [new Map<number, [number, number, string][]>(), new Map<number, [number, number, string][]>()] as const;

  add(points: readonly Point[]): void {
    const source = key(points[0]);
    for (let i = 1; i < points.length; i++) {
      const [a, b] = [points[i - 1]!, points[i]!];
      const flat = Math.abs(a.y - b.y) < 0.5;
      const of = this.lines[flat ? 0 : 1];
      const at = Math.round(flat ? a.y : a.x);
      const [from, to] = flat ? [a.x, b.x] : [a.y, b.y];
      of.set(at, [...(of.get(at) ?? []), [Math.min(from, to), Math.max(from, to), source]]);
    }
  }

  /** The length that a part of a line shares with wires of other ports. */
  shared(flat: boolean, at: number, from: number, to: number, source: string): number {
    let sum = 0;
    const [low, high] = from < to ? [from, to] : [to, from];
    for (let near = Math.round(at) - 3; near <= Math.round(at) + 3; near++)
      for (const [start, end, of] of this.lines[flat ? 0 : 1].get(near) ?? [])
        if (of !== source) sum += Math.max(0, Math.min(end, high) - Math.max(start, low));
    return sum;
  }
}

const key = (point: Point | undefined): string => (point ? `${Math.round(point.x)} ${Math.round(point.y)}` : "");
const sorted = (numbers: Iterable<number>): number[] => [...new Set(numbers)].sort((a, b) => a - b);

/** Places in the order of their costs: a binary heap. */
class Queue {
  private readonly items: number[] = [];
  private readonly costs: number[] = [];

  get size(): number {
    return this.items.length;
  }

  put(item: number, cost: number): void {
    let at = this.items.length;
    while (at > 0) {
      const up = (at - 1) >> 1;
      if (this.costs[up]! <= cost) break;
      this.items[at] = this.items[up]!;
      this.costs[at] = this.costs[up]!;
      at = up;
    }
    this.items[at] = item;
    this.costs[at] = cost;
  }

  take(): number {
    const first = this.items[0]!;
    const item = this.items.pop()!;
    const cost = this.costs.pop()!;
    const size = this.items.length;
    if (size) {
      let at = 0;
      for (;;) {
        let down = 2 * at + 1;
        if (down >= size) break;
        if (down + 1 < size && this.costs[down + 1]! < this.costs[down]!) down++;
        if (this.costs[down]! >= cost) break;
        this.items[at] = this.items[down]!;
        this.costs[at] = this.costs[down]!;
        at = down;
      }
      this.items[at] = item;
      this.costs[at] = cost;
    }
    return first;
  }
}

/** Whether a line through corners keeps clear of boxes, but for its ends. */
export function isClear(boxes: readonly Rectangle[], points: readonly Point[]): boolean {
  for (let i = 1; i < points.length; i++) {
    const [a, b] = [points[i - 1]!, points[i]!];
    const [left, right] = [Math.min(a.x, b.x) + 1, Math.max(a.x, b.x) - 1];
    const [top, bottom] = [Math.min(a.y, b.y) + 1, Math.max(a.y, b.y) - 1];
    for (const box of boxes) if (right > box.x && left < box.x + box.width && Math.max(top, bottom) > box.y && Math.min(top, bottom) < box.y + box.height) return false;
  }
  return true;
}

/** The corners of a wire, including its ends; undefined if it finds no way. */
export function route(boxes: readonly Rectangle[], { from, to }: Ends, taken: Taken): Point[] | undefined {
  const [left, right] = [Math.min(from.x, to.x) - REACH, Math.max(from.x, to.x) + REACH];
  const [top, bottom] = [Math.min(from.y, to.y) - REACH, Math.max(from.y, to.y) + REACH];
  const near = boxes.filter((each) => each.x < right && each.x + each.width > left && each.y < bottom && each.y + each.height > top);
  return search(near, from, to, taken) ?? (near.length < boxes.length ? search(boxes, from, to, taken) : undefined);
}

function search(boxes: readonly Rectangle[], from: Point, to: Point, taken: Taken): Point[] | undefined {
  const [start, end] = [{ x: from.x + LANES[0]!, y: from.y }, { x: to.x - LANES[0]!, y: to.y }];
  // A line through each box makes sure that a way through it has a place in it.
  const xs = sorted([start.x, end.x, (start.x + end.x) / 2, ...LANES.map((lane) => from.x + lane), ...LANES.map((lane) => to.x - lane), ...boxes.flatMap((each) => [each.x + each.width / 2, ...LANES.flatMap((lane) => [each.x - lane, each.x + each.width + lane])])]);
  const ys = sorted([start.y, end.y, ...boxes.flatMap((each) => [each.y + each.height / 2, ...LANES.flatMap((lane) => [each.y - lane, each.y + each.height + lane])])]);
  const [wide, high] = [xs.length, ys.length];
  const blocked = new Uint8Array(wide * high);
  for (const box of boxes)
    for (let i = 0; i < wide; i++)
      if (xs[i]! > box.x - CLEAR && xs[i]! < box.x + box.width + CLEAR)
        for (let j = 0; j < high; j++) if (ys[j]! > box.y - CLEAR && ys[j]! < box.y + box.height + CLEAR) blocked[j * wide + i] = 1;
  const place = ({ x, y }: Point) => ys.indexOf(y) * wide + xs.indexOf(x);
  const [begin, goal] = [place(start), place(end)];
  blocked[begin] = blocked[goal] = 0;
  const source = key(from);
  const best = new Float64Array(2 * wide * high).fill(Infinity);
  const before = new Int32Array(2 * wide * high).fill(-1);
  const queue = new Queue();
  // Even numbers are places that are reached on a flat line, odd ones on an upright one.
  best[2 * begin] = 0;
  queue.put(2 * begin, 0);
  let patience = PATIENCE;
  while (queue.size && patience-- > 0) {
    const state = queue.take();
    const [here, upright] = [state >> 1, state & 1];
    if (here === goal) return corners(before, state, xs, ys, wide, from, to);
    const [i, j] = [here % wide, Math.floor(here / wide)];
    for (let way = 0; way < 4; way++) {
      const flat = way < 2;
      const [ni, nj] = [i + (way === 0 ? 1 : way === 1 ? -1 : 0), j + (way === 2 ? 1 : way === 3 ? -1 : 0)];
      if (ni < 0 || nj < 0 || ni >= wide || nj >= high) continue;
      if (here === begin && way === 1) continue; // not back into its own port
      const next = nj * wide + ni;
      if (blocked[next]) continue;
      if (next === goal && way === 1) continue;
      const length = flat ? Math.abs(xs[ni]! - xs[i]!) : Math.abs(ys[nj]! - ys[j]!);
      const shared = flat ? taken.shared(true, ys[j]!, xs[i]!, xs[ni]!, source) : taken.shared(false, xs[i]!, ys[j]!, ys[nj]!, source);
      const turn = flat === (upright === 1) ? BEND : 0;
      const last = next === goal && !flat ? BEND : 0;
      const cost = best[state]! + length + SHARED * shared + turn + last;
      const reached = 2 * next + (flat ? 0 : 1);
      if (cost >= best[reached]!) continue;
      best[reached] = cost;
      before[reached] = state;
      queue.put(reached, cost + Math.abs(xs[ni]! - end.x) + Math.abs(ys[nj]! - end.y));
    }
  }
  return undefined;
}

function corners(before: Int32Array, last: number, xs: readonly number[], ys: readonly number[], wide: number, from: Point, to: Point): Point[] {
  const points: Point[] = [to];
  for (let state = last; state >= 0; state = before[state]!) points.push({ x: xs[(state >> 1) % wide]!, y: ys[Math.floor((state >> 1) / wide)]! });
  points.push(from);
  points.reverse();
  return points.filter((point, i) => {
    const [one, other] = [points[i - 1], points[i + 1]];
    return !one || !other || !((one.x === point.x && point.x === other.x) || (one.y === point.y && point.y === other.y));
  });
}
