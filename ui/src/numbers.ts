/** Measured numbers as they are shown: with as many digits as people read. */

/** The digits of a value that is shown; the picture of a curve, or a title, has the others. */
const DIGITS = 5;
/** From here on, a value is shown with an exponent. */
const LARGE = 1e7;

/** A value in few digits; empty for none. */
export const brief = (value: number): string =>
  Number.isNaN(value) ? "" : Math.abs(value) >= LARGE ? value.toExponential(3) : String(Number(value.toPrecision(DIGITS)));

const FRACTION = /(?<![\w.])-?\d+\.\d+(?:e[+-]?\d+)?(?![\w.])/g;

/** A text in which each number with a decimal point has few digits. */
export const briefly = (text: string): string => text.replaceAll(FRACTION, (number) => brief(Number(number)));

/** A time in the unit that suits it. */
export function duration(seconds: number): string {
  const [scale, unit] = seconds >= 1 ? [1, "s"] : seconds >= 1e-3 ? [1e3, "ms"] : [1e6, "µs"];
  return `${Number((seconds * scale).toPrecision(3))} ${unit}`;
}
