/** Types of travel commands, recognised by their members, and samples of them. */

import { draft, finish } from "./draft.ts";
import { serialize } from "./protocol/_cdr.ts";
import type { TypeTable } from "./protocol/table.ts";

/** Velocity in the frame of the body: forward and left [m/s], counter-clockwise [rad/s]. */
export interface Velocity {
  forward: number;
  left: number;
  turn: number;
}

export const REST: Velocity = { forward: 0, left: 0, turn: 0 };

/** The path of each part of a velocity in a sample; without `left`, only forward and turning. */
type Form = { forward: string; left?: string; turn: string };

/** The forms: IIS and RTC::Velocity2D, RTC::TimedVelocity, geometry_msgs::msg::Twist. */
const FORMS: readonly Form[] = [
  { forward: "vx", left: "vy", turn: "va" },
  { forward: "vx", left: "vy", turn: "w" },
  { forward: "v", turn: "w" },
  { forward: "linear.x", left: "linear.y", turn: "angular.z" },
];
/** Members that contain the velocity of a type. */
const INSIDE = ["data", "velocities", "twist"];
const DEEPEST = 3;
const NUMBERS = ["TYPE_FLOAT", "TYPE_DOUBLE"];

function isNumber(table: TypeTable, type: number, path: string): boolean {
  const [name, ...rest] = path.split(".");
  const member = table.nodes[type]?.members.find((each) => each.name === name && !each.optional);
  if (!member) return false;
  return rest.length ? isNumber(table, member.type, rest.join(".")) : NUMBERS.includes(table.nodes[member.type]?.kind ?? "");
}

/** Returns the writer of samples for a type of travel commands; undefined for other types. */
export interface Command {
  sideways: boolean;
  sample: (velocity: Velocity) => Uint8Array;
}

function formOf(table: TypeTable, type: number, depth = 0): Form | undefined {
  const node = table.nodes[type];
  if (node?.kind !== "TYPE_STRUCT" || depth > DEEPEST) return undefined;
  const names = node.members.map((each) => each.name);
  // A pose with a speed is not a command.
  const found = names.includes("x") ? undefined : FORMS.find((form) => Object.values(form).every((path) => isNumber(table, type, path)));
  if (found) return found;
  for (const name of INSIDE) {
    const member = node.members.find((each) => each.name === name && !each.optional);
    const inner = member && formOf(table, member.type, depth + 1);
    if (inner) return Object.fromEntries(Object.entries(inner).map(([part, path]) => [part, `${name}.${path}`])) as unknown as Form;
  }
  return undefined;
}

function put(value: unknown, path: string, number: number): void {
  const names = path.split(".");
  const last = names.pop()!;
  const owner = names.reduce((inner, name) => inner[name] as Record<string, unknown>, value as Record<string, unknown>);
  owner[last] = number;
}

/** How a type represents travel commands. A sample has no time stamp, so its age starts at its arrival. */
export function command(table: TypeTable, type: number): Command | undefined {
  const form = formOf(table, type);
  if (!form || !table.reads(type)) return undefined;
  return {
    sideways: form.left !== undefined,
    sample: ({ forward, left, turn }) => {
      const value = finish(table, type, draft(table, type));
      put(value, form.forward, forward);
      put(value, form.turn, turn);
      if (form.left) put(value, form.left, left);
      return serialize(table.codec(type), value);
    },
  };
}
