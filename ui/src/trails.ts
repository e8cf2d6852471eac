/** The trails of poses on the map, and whether a pose is that of a body or a goal. */

import type { Pose } from "./figures.ts";

const MAX_LENGTH = 5000;
/** Minimum distance between points of a trail [m]. */
const NEAREST = 0.005;
/** A pose that moves farther at once, faster than a vehicle, has jumped [m, m/s]. */
const LEAP = 0.3;
const FASTEST = 15;
/** Poses of a body follow each other within this time [s]. */
const SELDOM = 1;

/** Where a pose has been. */
export class Trail {
  /** The trail in parts, between which the pose has jumped. */
  readonly parts: Pose[][] = [];
  private last: { time: number; pose: Pose } | undefined;
  private moves = 0;
  private leaps = 0;
  private length = 0;

  /** Adds a pose of a time [s]; `thinned`: older ones may be left out before it. */
  add(time: number, pose: Pose, thinned: boolean): void {
    const { last } = this;
    this.last = { time, pose };
    let part = this.parts.at(-1);
    if (last && part) {
      const [far, passed] = [Math.hypot(pose.x - last.pose.x, pose.y - last.pose.y), time - last.time];
      const leaps = far > LEAP && far > FASTEST * passed;
      // Samples may have been left out before one that comes late: it shows what kind of pose this is, but does not cut the trail.
      if (leaps || (far > LEAP && passed > SELDOM && !thinned)) this.leaps += 1;
      else if (far > 0) this.moves += 1;
      if (leaps) part = undefined;
    }
    if (!part) this.parts.push((part = []));
    const before = part.at(-2);
    if (before && Math.hypot(pose.x - before.x, pose.y - before.y) < NEAREST) part.pop();
    else this.length += 1;
    part.push(pose);
    while (this.length > MAX_LENGTH && this.parts[0]) {
      const [oldest] = this.parts;
      if (oldest.length > 1) oldest.shift();
      else this.parts.shift();
      this.length -= 1;
    }
  }

  /** Whether the pose moves by jumps alone. */
  get jumps(): boolean {
    return this.leaps > 0 && this.moves <= this.leaps;
  }

  /** Begins the trail again where the pose is. */
  clear(): void {
    const { last } = this;
    this.parts.length = 0;
    this.length = last ? 1 : 0;
    if (last) this.parts.push([last.pose]);
  }
}

/** Words of names of ports and types whose poses are to be reached. */
const AIM = /goal|target|destination|way_?point|command|desired|reference|setpoint|(^|[._])path$/i;
/** Names of InPorts that only take what is to be reached. */
const TAKES_AIM = /goal|destination|way_?point/i;

/** Whether a port's poses are to be reached, by its name, that of its type, and those of the InPorts that it is connected to. */
export const isAim = (port: string, type: string, inPorts: readonly string[]): boolean => AIM.test(port) || AIM.test(type.split("::").at(-1)!) || inPorts.some((each) => TAKES_AIM.test(each));
