/** Measured numbers as they are shown: with as many digits as people read. */

/** The digits of a value that is shown; the picture of a curve, or a title, has the others. */
const DIGITS = 5;
/** A longer text, beside its sign, has an exponent instead: columns of tables have no more room. */
const LONGEST = 8;

/** A value in few digits; empty for none. */
export function brief(value: number): string {
  if (Number.isNaN(value)) return "";
  const short = Number(value.toPrecision(DIGITS));
  return String(Math.abs(short)).length > LONGEST ? Number(value.toPrecision(DIGITS - 1)).toExponential() : String(short);
}

const FRACTION = /(?<![\w.])-?\d+\.\d+(?:e[+-]?\d+)?(?![\w.])/g;

/** A text in which each number with a decimal point has few digits. */
export const briefly = (text: string): string => text.replaceAll(FRACTION, (number) => brief(Number(number)));

/** A time in the unit that suits it. */
export function duration(seconds: number): string {
  const [scale, unit] = seconds >= 1 ? [1, "s"] : seconds >= 1e-3 ? [1e3, "ms"] : [1e6, "µs"];
  return `${Number((seconds * scale).toPrecision(3))} ${unit}`;
}
